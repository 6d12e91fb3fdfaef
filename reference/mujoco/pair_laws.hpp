// Laws of pairs from MuJoCo's coefficients of geoms. The geom of higher priority determines a contact's friction; at
// equal priority the larger coefficient does. One priority and one law per material are therefore sufficient when the
// materials have an order in which each has the same law with all lower ones (and with itself, where two such bodies
// can touch).
#pragma once

#include <optional>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::mujoco {

struct Precedence {
  int priority = 0;
  double friction = 0, rolling_friction_m = 0;
};

// One entry per material; absent when no such order exists, so that every pair of geoms has to be listed.
std::optional<std::vector<Precedence>> precedences(const Scene& scene);

}  // namespace atwood::mujoco
