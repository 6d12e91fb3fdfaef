// Time of impact of two bodies in straight motion with constant spin: exact for spheres and planes (a root of a
// quadratic or a line), conservative advancement (Mirtich 1996; Zhang, Lee, Kim 2006) for the rest, part by part. The
// steps are lower bounds on the time of impact, so no contact is passed over.
#pragma once

#include <optional>

#include "collision/contacts.hpp"

namespace atwood {

template <class S> struct SweptBody {
  Vec3<S> p_W;  // at t = 0
  Quat<S> q_WB;
  Vec3<S> v_W, w_W;  // constant, world axes
};

template <class S> struct Touch {
  S t_s{};                 // 0 for bodies that overlap at the start
  Vec3<S> x_W, normal_W;   // the point midway; unit normal from a to b, at that time
  SolveReport solve = {};  // of conservative advancement; iterations 0: the touch is a root in closed form
};

// The first touch within [0, t_end_s]; none if the bodies stay apart or their pair of kinds has no test.
template <class S>
std::optional<Touch<S>> time_of_impact(const Geometry<S>& a, const SweptBody<S>& from_a, const Geometry<S>& b,
                                       const SweptBody<S>& from_b, S t_end_s);

}  // namespace atwood
