// The triangles of a convex hull, by exact signs.
#pragma once

#include <array>
#include <vector>

#include "scene/scene.hpp"

namespace atwood {

// Indices into `points`, anticlockwise as seen from outside. The signs are exact: no point lies outside any triangle's
// plane. Empty if all points lie in one plane, within 64 ulp of their extent.
std::vector<std::array<int, 3>> hull_triangles(const std::vector<Real3>& points);

}  // namespace atwood
