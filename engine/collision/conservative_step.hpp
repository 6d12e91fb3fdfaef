// One step of conservative advancement (Mirtich 1996): a lower bound on the time until two bodies in straight motion
// with constant angular velocity touch.
//
// Bodies that are not convex are bounded part by part and the least bound is returned: the nearest parts need not be
// those that touch first (a ball that flies close above a floor towards a wall).
#pragma once

#include <limits>
#include <vector>

#include "collision/contacts.hpp"

namespace atwood {

// A body at one instant: its shape, its pose and its angular velocity [rad/s].
template <class S> struct RotatingBody {
  const Geometry<S>& shape;
  Transform<S> pose;
  Vec3<S> w_W;  // constant, world axes
};

template <class S> struct ConservativeStep {
  S step_s{};                                  // no contact before now + step_s; infinite: none before max_s
  bool touching = false;                       // some gap is at most `round_off`; step_s is then 0
  S gap = std::numeric_limits<S>::infinity();  // least gap of the parts that were compared [m]
  Vec3<S> normal_W{};                          // unit, from a to b, of the parts that set step_s
};

// `v_W`: a's velocity less b's [m/s]; `max_s`: the end of the search; a gap of at most `round_off` counts as a touch.
// A closed mesh is treated as its surface: a body that starts inside of it is not detected.
template <class S>
ConservativeStep<S> conservative_step(const RotatingBody<S>& a, const RotatingBody<S>& b, const Vec3<S>& v_W, S max_s,
                                      S round_off);

}  // namespace atwood
