// The engine that this executable was built with.
#pragma once

#include "scenes.hpp"

namespace atwood::test {

Engine engine_under_test();

inline bool in_float(const Engine& engine) { return engine.scalar == "float"; }
inline bool is_bullet(const Engine& engine) { return engine.name != "ode"; }

}  // namespace atwood::test
