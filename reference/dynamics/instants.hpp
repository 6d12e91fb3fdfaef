// A motion with contacts as the list of the instants at which something happened; the growth of errors is computed along
// it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "dynamics/simultaneous.hpp"

namespace atwood::dynamics {

// A ball whose bounces to come are summed as a geometric series: what the sum leaves out.
template <class S> struct Laid {
  ContactPair pair;
  int ball = -1;
  Real3 normal{};
  S until{};                      // when the last bounce ends
  S bar_s{};                      // by how much that may be off, as the pull is not constant
  S height_m{}, speed_m_per_s{};  // of the bounces left out: none is higher or faster
  S per_speed{};                  // seconds of bouncing for each m/s that the ball leaves with
  std::vector<S> push;            // what the bounces left out may change of each component of y
  bool told = false;              // there is an event of it
};

// What happened at one instant.
template <class S> struct Instant {
  S t{};
  int interval = 0;
  double steps = 0;          // taken since the instant before
  std::int64_t sample = -1;  // which one this is
  S off_m{};                 // how far from zero the gaps of what was struck were
  std::vector<Blow<S>> blows;
  std::vector<Laid<S>> laid;
  std::optional<ContactPair> passed;  // came near, and did not touch
  std::size_t first_event = 0;
  std::vector<S> after;  // the state
};

}  // namespace atwood::dynamics
