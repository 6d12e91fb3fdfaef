// Points on the free surface of a fluid at t = 0, for methods that carry the surface along.
//
// D is the spacing. A box: on each side across an open axis, or across a periodic one that the box does not fill,
// unless a plane of a boundary lies within D / 2 of it: the middles of square cells of edges L / round(L / D). A circle
// or an ellipse of semi-axes a, b: n = round(2 pi sqrt(a b) / D) points at equal steps of the angle, the first on the x
// axis. A ball or an ellipsoid: n = round(4 pi (a b c)^(2/3) / D^2) points (a s cos p, b s sin p, c z) with z = 1 - (2
// k + 1) / n, s^2 = 1 - z^2 and p = k pi (3 - sqrt 5) (Fibonacci's lattice). Points on or behind a boundary (to 1e-9 D)
// are left out. In two dimensions all points have z = 0.
#pragma once

#include <vector>

#include "scene/scene.hpp"

namespace atwood {

// Of the scene's only fluid, in the order above (sides by axis, lower first). Empty: there is no free surface. Throws
// std::invalid_argument for a region of points, whose surface is not known, where some axis is open.
std::vector<Real3> surface_points(const Scene& scene);

}  // namespace atwood
