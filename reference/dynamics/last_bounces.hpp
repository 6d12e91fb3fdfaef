// How a bouncing ball comes to rest on a plane: infinitely many bounces in a finite time, summed as a series.
#pragma once

#include "dynamics/instants.hpp"
#include "dynamics/rates.hpp"

namespace atwood::dynamics {

template <class S> struct LastBounces {
  bool attracted = false;  // the bodies accelerate towards each other; otherwise there is no next bounce
  bool at_rest = false;    // the normal relative velocity is zero to within the tolerance
  bool converges = false;  // the series has a finite sum for every acceleration within the bounds below
  S flight_s{};            // duration of the next flight
  BounceSeries<S> series;
  std::vector<S> y_at_rest;  // y without the ball's normal velocity
  std::vector<S> dydt;       // rates at (t, y)
};

// The bounces to come of a pair that touches and separates at (t, y) with normal velocity v. A pair slower than
// `speed_tolerance` [m/s] is at rest. With a constant acceleration a towards each other a flight takes 2 v / a, and all
// flights to come take
//   T = sum_k 2 v e^k / a = 2 v / (a (1 - e)).
// While the acceleration stays within (1 +- c) a, each flight and each return speed do so too, and
//   2 v / a (1 - c) / (1 - e (1 - c)) <= T <= 2 v / a (1 + c) / (1 - e (1 + c)).
// c is twice the relative change of the acceleration between four states: the given one, the ball falling at v, the
// ball at rest now, and the ball at rest after T.
// `dydt` and `attracted` are always filled; `series` only for a ball on a plane with e < 1.
template <class S>
LastBounces<S> last_bounces(const Scene& scene, const Dynamics<S>& dynamics, const ContactPair& pair, S t_s, const S* y,
                            int interval, S speed_tolerance);

}  // namespace atwood::dynamics
