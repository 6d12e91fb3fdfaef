// Exact signs of determinants, and the exact intersection test of two triangles.
#pragma once

#include <array>

#include "math/vec3.hpp"

namespace atwood {

// The sign (-1, 0, 1) of (a - d) . (b - d) x (c - d): positive when a, b, c run clockwise seen from d. A bound on
// round-off decides nearly always; else the determinant is summed exactly as an expansion of non-overlapping terms
// (Shewchuk, Discrete Comput. Geom. 18 (1997) 305). Exact unless products of three coordinates under- or overflow.
template <class S> int orient3d(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c, const Vec3<S>& d);
// The sign of the turn a -> b -> c in the plane: positive anticlockwise. Exact, as orient3d.
template <class S> int orient2d(const std::array<S, 2>& a, const std::array<S, 2>& b, const std::array<S, 2>& c);

template <class S> using Corners = std::array<Vec3<S>, 3>;
// Do two closed triangles share a point? Decided exactly by signs (cases as in Guigue, Devillers, J. Graph. Tools 8
// (2003) 25): planes apart, then edges of one through the other, or both in one plane. At least one of them must have
// an area.
template <class S> bool triangles_intersect(const Corners<S>& p, const Corners<S>& q);

}  // namespace atwood
