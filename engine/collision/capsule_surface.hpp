// Distances to the surface of a capsule: from its segment, and along a ray.
#pragma once

#include "math/vec3.hpp"

namespace atwood {

// The distance d from the segment's point at coordinate `along` (|along| <= half_length) to the surface in a unit
// direction whose component along the axis is `cosine`: through the tube, d = radius / sine, or through the cap about
// the end e, where |d direction + (along - e) axis| = radius. 0 if the radius is 0.
template <class S> S core_to_surface(S radius, S half_length, S along, S cosine) {
  if (!(radius > S(0))) return S(0);
  const S square = (S(1) - cosine) * (S(1) + cosine), sine = square > S(0) ? real::sqrt(square) : S(0);
  const S exit_along = along * sine + radius * cosine;  // times 1 / sine, along the axis
  if (real::abs(exit_along) <= half_length * sine && sine > S(0)) return radius / sine;
  const S past_end = along - (exit_along < S(0) ? -half_length : half_length);
  const S radicand = radius * radius - past_end * past_end * (sine * sine);
  return (radicand > S(0) ? real::sqrt(radicand) : S(0)) - past_end * cosine;
}

// Ray cast: the least d > 0 at which from + d n meets a capsule about the origin (`axis` and n are unit vectors). No
// intersection: `found` is false and 0 is returned.
template <class S>
S raycast_capsule(const Vec3<S>& from, const Vec3<S>& n, const Vec3<S>& axis, S radius, S half_length, bool& found) {
  const S along = dot(from, axis), cosine = dot(n, axis);
  const Vec3<S> from_across = from - along * axis, n_across = n - cosine * axis, moment = cross(from_across, n_across);
  const S square = dot(n_across, n_across), radicand = square * (radius * radius) - dot(moment, moment);
  found = radicand >= S(0) && square > S(0);
  if (!found) return S(0);
  const S distance = -(dot(from_across, n_across) + real::sqrt(radicand)) / square, at = along + distance * cosine;
  if (real::abs(at) <= half_length) return distance;
  const Vec3<S> to_end = (at < S(0) ? -half_length : half_length) * axis - from, end_moment = cross(to_end, n);
  const S cap = radius * radius - dot(end_moment, end_moment);
  found = cap >= S(0);
  return found ? dot(to_end, n) - real::sqrt(cap) : S(0);
}

}  // namespace atwood
