// How long two bodies in straight motion with constant spin certainly stay apart: what conservative advancement steps
// by.
//
// Bodies that are not convex are looked at part by part: the nearest parts alone say nothing of the wall that a ball
// flies at close above the floor.
#pragma once

#include <limits>
#include <vector>

#include "collision/contacts.hpp"

namespace atwood {

// A body at one instant.
template <class S> struct Spinning {
  const Geometry<S>& shape;
  Placement<S> place;
  Vec3<S> w_W;  // constant, world axes
};

template <class S> struct Stay {
  S until_s{};                                 // from now; infinite: to the end
  bool touching = false;                       // within round-off
  S gap = std::numeric_limits<S>::infinity();  // the least of the parts looked at
  Vec3<S> normal_W{};                          // from a to b, between the parts that rule
};

// `v_W` is a's velocity less b's, `most_s` the time that is left. A gap of `round_off` is a touch. A closed mesh is its
// surface here: what starts inside of it is not seen.
template <class S>
Stay<S> stay_apart(const Spinning<S>& a, const Spinning<S>& b, const Vec3<S>& v_W, S most_s, S round_off);

}  // namespace atwood
