// A run of an engine with what was observed.
#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "scene/scene.hpp"

namespace atwood::testing {

struct Recorded {
  Outcome outcome;
  std::vector<Sample> samples;
  std::vector<Event> events;

  // Of a body in the last sample.
  Real3 p(int body) const { return doubles(samples.back().bodies[static_cast<std::size_t>(body)].p_m); }
  Real3 v(int body) const { return doubles(samples.back().bodies[static_cast<std::size_t>(body)].v_m_per_s); }
  Real3 w(int body) const { return doubles(samples.back().bodies[static_cast<std::size_t>(body)].w_rad_per_s); }
  int count(EventKind kind) const {
    int found = 0;
    for (const Event& event : events) found += event.kind == kind;
    return found;
  }
  static Real3 doubles(const std::array<Wide, 3>& x) {
    return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
  }
};

// Whatever the outcome's status. `run`: Engine::run, or a function with the same parameters.
template <class Run> Recorded record(const Run& run, const MethodId& id, const Scene& scene, const Plan& plan) {
  Recorded recorded;
  Observer observer;
  observer.sample = [&](const Sample& sample) { recorded.samples.push_back(sample); };
  observer.event = [&](const Event& event) { recorded.events.push_back(event); };
  recorded.outcome = run(id, scene, plan, observer, 0);
  return recorded;
}

// The test fails here unless the run ended ok with all its samples.
inline void require_whole(const Recorded& recorded, const std::string& method, const Plan& plan) {
  INFO(method << ": " << to_string(recorded.outcome.status) << ", " << recorded.outcome.reason);
  REQUIRE(recorded.outcome.status == Status::ok);
  REQUIRE(static_cast<std::int64_t>(recorded.samples.size()) == plan.samples + 1);
}

}  // namespace atwood::testing
