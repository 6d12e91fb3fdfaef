// The engine that this executable was built with.
#pragma once

#include "scenes.hpp"

namespace atwood::test {

Engine engine_under_test();

inline bool in_float(const Engine& engine) { return engine.scalar == "float"; }
inline bool is_bullet(const Engine& engine) { return engine.name.rfind("bullet", 0) == 0; }
inline bool bounces(const Engine& engine) { return engine.name != "mujoco"; }  // has a coefficient of restitution
// The settings in which one body alone is at its most exact, for laws that the engine can keep. (A tuned
// preset depends on the class of the scene.)
inline MethodId sharpest(const Engine& engine) {
  using Whole = std::int64_t;
  if (is_bullet(engine))
    return method(engine, "default",
                  {{"contact_processing_threshold_m", 0.0},
                   {"restitution_velocity_threshold_m_per_s", 1e-6},
                   {"split_impulse_penetration_threshold_m", 0.0},
                   {"iterations", Whole{50}},
                   {"smooth_inner_edges", true}});
  if (engine.name == "ode")
    return method(engine, "default",
                  {{"erp", 0.0}, {"friction_direction", std::string("slip")}, {"finite_rotation", true}});
  return method(engine, "stiff");
}

// The presets that move by v += h F/m, x += h v.
inline std::vector<std::string> semi_implicit(const Engine& engine) {
  if (engine.name == "mujoco") return {"default", "implicit"};
  return {"default", "tuned"};
}

}  // namespace atwood::test
