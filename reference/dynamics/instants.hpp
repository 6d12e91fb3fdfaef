// A motion with contacts as the list of the instants at which something happened. shared_errors.hpp propagates errors
// along this list.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "dynamics/simultaneous.hpp"

namespace atwood::dynamics {

// The infinitely many bounces in finite time with which a ball comes to rest on a plane (Zeno behaviour: B. Brogliato,
// Nonsmooth Mechanics, 2016), summed as a geometric series. The ball is at rest on the plane from `t_rest`
// on; the other fields bound what the sum neglects.
template <class S> struct BounceSeries {
  ContactPair pair;
  int ball = -1;                  // index of the body that bounces; -1: neither body is a plane
  Real3 normal{};                 // of the plane, as in the scene (unit to round-off)
  S t_rest{};                     // [s] end of the last bounce
  S bar_s{};                      // half-width of t_rest: the relative acceleration is not constant
  S height_m{}, speed_m_per_s{};  // largest height and speed of the neglected bounces
  S duration_per_speed{};         // [s / (m/s)] duration of the series for each m/s of the ball's rebound
  std::vector<S> neglected;       // change of each component of y by the neglected bounces, at most
  bool has_event = false;         // the events of the run contain a rest event for this series
};

// What happened at one instant.
template <class S> struct Instant {
  S t{};                     // [s]
  int interval = 0;          // between switches: see Dynamics::rate
  double steps = 0;          // number of integration steps since the instant before
  std::int64_t sample = -1;  // number of the sample taken here; -1: none
  S gap_error_m{};           // largest |gap| of the contacts at their located impact
  std::vector<Impact<S>> impacts;
  std::vector<BounceSeries<S>> series;
  std::vector<int> lifted;             // balls at rest whose normal force falls to zero here, before the impacts
  std::optional<ContactPair> passage;  // this pair was closest here and did not touch
  std::size_t first_event = 0;         // index of the first event of this instant in the run's events
  std::vector<S> after;                // y after the impacts
};

}  // namespace atwood::dynamics
