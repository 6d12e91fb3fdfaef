#include "bullet/bullet.hpp"

#include <LinearMath/btScalar.h>

#include "bullet/bullet_world.hpp"
#include "bullet/contacts.hpp"
#include "rivals/rival.hpp"

namespace atwood {

Engine bullet_engine() {
  constexpr bool is_double = sizeof(btScalar) == 8;
  rivals::Rival rival;
  rival.name = is_double ? "bullet64" : "bullet32";
  rival.version = std::to_string(BT_BULLET_VERSION / 100) + "." + std::to_string(BT_BULLET_VERSION % 100);
  rival.scalar = is_double ? "double" : "float";
  rival.source = "Coumans, Bullet 3.24 Physics SDK manual; btDiscreteDynamicsWorld";
  rival.presets = {
      {"default",
       "Bullet's rigid bodies with the library's default settings: symplectic Euler, implicit gyroscopic term, "
       "sequential impulses with speculative contacts. Only sleeping is off, and pairs have the contact law of the "
       "scene."},
      {"tuned",
       "Bullet with the settings that `atwood tune` found for the class of the scene (free flight, bounce, friction, stack, "
       "heap): the default's where none were better on scenes held out.",
       {},
       {},
       false,
       true}};
  rival.settings = bullet::settings();
  rival.refusal = [](const Scene& scene, const Settings&) { return bullet::refusal(scene); };
  rival.make = bullet::make_world;
  Engine engine = rivals::engine_of(rival);
  engine.contacts = bullet::find_contacts;
  return engine;
}

}  // namespace atwood
