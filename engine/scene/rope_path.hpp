// The straight parts of a rope over its pulleys.
#pragma once

#include <string>
#include <vector>

#include "scene/quad_vectors.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Unit vectors along the straight parts in the order from the first body to the last. With points p, q of the two
// bodies the length of the rope changes by -directions.front() . p' + directions.back() . q'.
struct RopePath {
  std::vector<quad::Vector> directions;
};

// Between nodes with centres a and b, radii and senses, the part of direction d and length L satisfies
//   L d = b - a + k d x n
// with n the axis and k the difference of radius times sense, so that
//   L^2 = |b - a|^2 - k^2
//   d = (L (b - a) + k (b - a) x n) / |b - a|^2
// Returns what forbids it ("its pulley 1 has ..."), or nothing. `ends_m`: the points of the bodies, world.
std::string rope_path(const Rope& rope, const std::array<quad::Vector, 2>& ends_m, RopePath& out);

}  // namespace atwood
