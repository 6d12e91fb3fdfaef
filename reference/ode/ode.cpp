#include "ode/ode.hpp"

#include "ode/contacts.hpp"
#include "ode/ode_world.hpp"
#include "rivals/rival.hpp"

namespace atwood {

Engine ode_engine() {
  rivals::Rival rival;
  rival.name = "ode";
  rival.version = "0.16.2";
  rival.scalar = "double";
  rival.source = "Smith, Open Dynamics Engine v0.5 user guide; ODE 0.16.2";
  rival.presets = {
      {"default",
       "ODE with the defaults of dWorldCreate, stepped by dWorldStep: symplectic Euler, contacts and joints by a "
       "linear complementarity problem. Friction is a coefficient, and pairs have the contact law of the scene."},
      {"tuned",
       "ODE with the settings that `atwood tune` found for the class of the scene (free flight, bounce, friction, stack, "
       "heap): the default's where none were better on scenes held out, and for mechanisms, which have had no search yet.",
       {},
       {},
       false,
       true}};
  rival.settings = ode::settings();
  rival.refusal = ode::refusal;
  rival.joints = true;
  rival.make = ode::make_world;
  rival.diagnostics = ode::diagnostics_since_last_call;
  Engine engine = rivals::engine_of(rival);
  engine.contacts = ode::find_contacts;
  return engine;
}

}  // namespace atwood
