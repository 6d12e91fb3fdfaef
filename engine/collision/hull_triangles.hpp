// The triangles of a convex hull, by exact signs.
#pragma once

#include <array>
#include <vector>

#include "scene/scene.hpp"

namespace atwood {

// Anticlockwise from outside; no point lies outside by any amount. Empty when the points are flat: within round-off of
// their extent (64 ulp) of one plane.
std::vector<std::array<int, 3>> hull_triangles(const std::vector<Real3>& points);

}  // namespace atwood
