// The engine that this executable was built with.
#pragma once

#include "scenes.hpp"

namespace atwood::test {

Engine engine_under_test();

inline bool in_float(const Engine& engine) { return engine.scalar == "float"; }
inline bool is_bullet(const Engine& engine) { return engine.name.rfind("bullet", 0) == 0; }
inline bool bounces(const Engine& engine) { return engine.name != "mujoco"; }  // has a coefficient of restitution
// The presets that move by v += h F/m, x += h v.
inline std::vector<std::string> semi_implicit(const Engine& engine) {
  if (engine.name == "mujoco") return {"default", "implicit"};
  return {"default", "tuned"};
}

}  // namespace atwood::test
