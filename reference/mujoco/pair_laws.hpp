// A pair's law out of what MuJoCo lets a geom say. The geom of higher priority decides a contact's friction; at equal
// priority the larger coefficient wins. So one priority and one law a material do where the materials can be put in an
// order in which each has the same law with all that come below it (and with itself, where it can meet itself).
#pragma once

#include <optional>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::mujoco {

struct Precedence {
  int priority = 0;
  double friction = 0, rolling_friction_m = 0;
};

// One entry a material; absent where no such order exists, and every pair of geoms has to be listed.
std::optional<std::vector<Precedence>> precedences(const Scene& scene);

}  // namespace atwood::mujoco
