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
  Settings tuned = simbody::settings_of("RungeKuttaMerson", 1e-10);
  tuned["steps"] = std::string("chosen");
  rival.presets = {
      {"default",
       "Simbody's Runge-Kutta-Merson in steps of fixed size: the error estimate is computed, and every step is "
       "accepted.",
       simbody::settings_of("RungeKuttaMerson", 1e-3)},
      {"tuned",
       "Runge-Kutta-Merson that chooses its steps at an accuracy of 1e-10; the plan's step count only sets the first "
       "step.",
       tuned},
      {"rk-merson",
       "Runge-Kutta-Merson; with a tolerance, which is Simbody's accuracy, it chooses its steps.",
       simbody::settings_of("RungeKuttaMerson", 1e-3),
       {},
       true}};
  rival.fixed = simbody::fixed_settings();
  rival.compliant = true;
  rival.check = simbody::check_settings;
  rival.refusal = [](const Scene& scene, const Settings&) { return simbody::refusal(scene); };
  rival.make = simbody::make_world;
  rival.diagnostics = simbody::diagnostics_since_last_call;
  return rivals::engine_of(rival);
}

}  // namespace atwood
