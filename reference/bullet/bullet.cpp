#include "bullet/bullet.hpp"

#include <LinearMath/btScalar.h>

#include "bullet/bullet_world.hpp"
#include "bullet/contacts.hpp"
#include "bullet/multibody_world.hpp"
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
       "sequential impulses for joints and speculative contacts. Only sleeping is off, and pairs have the contact law of the "
       "scene."},
      {"tuned",
       "Bullet with the settings that `atwood tune` found for the class of the scene (free flight, bounce, friction, stack, "
       "heap): the default's where none were better on scenes held out, and for mechanisms, which have had no search yet.",
       {},
       {},
       false,
       true},
      {"multibody",
       "Bullet's btMultiBody, in reduced coordinates: the articulated-body algorithm and semi-implicit Euler; closing joints, "
       "stops and driven rates by sequential impulses. Damping, 0.04 unless set, is off, and rates are not bounded (100 "
       "unless set).",
       {{"formulation", std::string(bullet::kReduced)}, {"multibody_integrator", std::string(bullet::kSemiImplicit)}}},
      {"multibody-rk4",
       "The same with useRK4Integration: Runge-Kutta in four stages, for trees without stops and driven rates. "
       "It is of order 4 on hinges and sliders, 2 on balls, and 1 in the attitude of a free base. Springs, dampers and motors, "
       "which the adapter evaluates, stay constant over the step: order 1 with them.",
       {{"formulation", std::string(bullet::kReduced)}, {"multibody_integrator", std::string(bullet::kRungeKutta)}}}};
  rival.settings = bullet::settings();
  rival.refusal = bullet::refusal;
  rival.joints = true;
  rival.make = bullet::make_world;
  Engine engine = rivals::engine_of(rival);
  engine.contacts = bullet::find_contacts;
  return engine;
}

}  // namespace atwood
