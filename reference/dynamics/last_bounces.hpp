// How a bouncing ball comes to rest on a plane: infinitely many bounces in a finite time, summed as a series.
#pragma once

#include "dynamics/instants.hpp"
#include "dynamics/rates.hpp"

namespace atwood::dynamics {

template <class S> struct LastBounces {
  bool pulled = false;  // towards each other: else there is no next bounce
  bool lies = false;    // neither bounces nor approaches
  bool ends = false;    // the series converges whatever the pull does meanwhile
  S flight_s{};         // the next one
  Laid<S> laid;
  std::vector<S> held;  // y with the gap's rate removed from the ball
  std::vector<S> dydt;
};

// Of a pair that touches and leaves at (t, y) at the gap's rate v; slower than `slow` it lies. A flight takes 2 v / a
// against a pull a, and all flights to come
//   T = sum_k 2 v e^k / a = 2 v / (a (1 - e)).
// Where the pull stays within (1 +- c) a meanwhile, so does about each flight and each speed of return, and
//   2 v / a (1 - c) / (1 - e (1 - c)) <= T <= 2 v / a (1 + c) / (1 - e (1 + c)).
// c is twice what the pull changes by when the ball leaves, when it falls as fast, and when it has come to rest.
template <class S>
LastBounces<S> last_bounces(const Scene& scene, const Dynamics<S>& dynamics, const ContactPair& pair, S t_s, const S* y,
                            int interval, S slow);

}  // namespace atwood::dynamics
