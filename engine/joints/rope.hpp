// The path of a rope from a point of one body over fixed pulleys to a point of another, and the constraint that its
// length imposes.
//
// Straight parts between the points and the pulleys, each touching its pulleys; arcs on them. With n the pulleys' axis,
// d the direction of a straight part from its first end to its last and rho = radius (axis . n), it touches a pulley at
// axle + rho d x n, so that two ends at v from each other satisfy
//   v + (rho_last - rho_first) d x n = l d.
// The part has the length
//   l = sqrt(v^2 - (rho_last - rho_first)^2)
// and d is v rotated about n by asin((rho_first - rho_last) / |v|).
//
// Where a touching point moves, the part beside it grows as the arc shrinks, so the rate of the whole length is
//   L' = d_last . x_last' - d_first . x_first',
// and a part of length l that ends in a moving point turns at |x'_across| / l, across d, which gives
//   L'' = d_last . x_last'' - d_first . x_first'' + |x'_last across|^2 / l_last + |x'_first across|^2 / l_first.
// The rope runs at s' = d_first . x_first', and without slip a pulley turns at s' / radius; so pulleys of inertia I add
// the mass sum I / radius^2 to what moves along the rope.
#pragma once

#include <string>
#include <vector>

#include "joints/constraint.hpp"

namespace atwood {

template <class S> struct RopeConstraint {
  int body[2] = {0, 0};
  Vec3<S> point_B[2];
  struct Pulley {
    Vec3<S> axle, axis;
    S radius{}, angle{};
  };
  std::vector<Pulley> pulleys;
  S mass_kg{};    // sum of I / radius^2
  S length_m{};   // constant: the length at the start
  S first_m{};    // length of the first straight part at the start
  S first_rad{};  // angle of its direction about the first axis at the start, from `reference`
  Vec3<S> reference;
};
template <class S> RopeConstraint<S> rope_constraint(const Rope& rope);

// At one configuration.
template <class S> struct RopePath {
  S length_m{};
  Vec3<S> x[2], r[2];           // the ends, and the ends from their bodies' centres, world axes
  Vec3<S> direction[2];         // of the straight parts at the first and at the last end
  S straight_m[2] = {};         // their lengths
  const char* fault = nullptr;  // not null: why there is no such path
};
// The path between the ends at the bodies' present poses; `fault` is set where there is none.
template <class S>
RopePath<S> rope_path(const RopeConstraint<S>& rope, const TiedBody<S>& first, const TiedBody<S>& last);

// Takes the length and the angles of this path as those of the start.
template <class S> void start_rope(const RopePath<S>& path, RopeConstraint<S>& rope);

// How far the rope has run over its pulleys since the start [m]; `previous_angle`: that of its first part at the
// last call, which it continues.
template <class S> S rope_travel(const RopeConstraint<S>& rope, const RopePath<S>& path, S& previous_angle);

// The rows: with mass_kg = 0 one, whose multiplier is minus the tension; else two that share the rope's speed s' as an
// extra unknown of that mass, with coefficient -1 in both,
//   d_first . x_first' - s' = 0, its multiplier the tension at the first end,
//   d_last . x_last' - s' = 0,   its multiplier minus the tension at the last end.
// on[0]: the first body.
template <class S>
int rope_rows(const RopeConstraint<S>& rope, const RopePath<S>& path, const TiedBody<S>& first, const TiedBody<S>& last,
              JointRow<S>* rows);

}  // namespace atwood
