#include "simbody/simbody.hpp"

#include "rivals/rival.hpp"
#include "simbody/simbody_world.hpp"

namespace atwood {

Engine simbody_engine() {
  rivals::Rival rival;
  rival.name = "simbody";
  rival.version = simbody::version();
  rival.scalar = "double";
  rival.source = "Sherman, Seth and Delp 2011, Simbody: multibody dynamics for biomedical research; Simbody 3.7";
  rival.presets = {
      {"default",
       "Simbody's Runge-Kutta-Merson in steps of fixed size: the error estimate is computed, and every step is "
       "accepted."},
      {"tuned",
       "Simbody with the settings that `atwood tune` found for the class of the scene (free flight, bounce, mechanism): "
       "the default's where none were better on scenes held out and worse nowhere in the class.",
       {},
       {},
       false,
       true},
      {"chosen",
       "Runge-Kutta-Merson that chooses its steps at an accuracy of 1e-10; the plan's step count only sets the first "
       "step.",
       {{"accuracy", 1e-10}, {"steps", std::string("chosen")}}},
      {"rk-merson",
       "Runge-Kutta-Merson; with a tolerance, which is Simbody's accuracy, it chooses its steps.",
       {},
       {},
       true},
      {"cpodes",
       "Simbody's CPodes: the Adams methods of CVODE with projection, in chosen steps; with a tolerance, which is its "
       "accuracy, otherwise 1e-10. Refuses quaternions and loops.",
       {{"integrator", std::string("CPodes")}, {"accuracy", 1e-10}, {"steps", std::string("chosen")}},
       {},
       true}};
  rival.settings = simbody::settings();
  rival.compliant = true;
  rival.joints = true;
  rival.contradiction = simbody::contradiction;
  rival.refusal = simbody::refusal;
  rival.make = simbody::make_world;
  rival.diagnostics = simbody::diagnostics_since_last_call;
  return rivals::engine_of(rival);
}

}  // namespace atwood
