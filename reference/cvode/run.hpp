// A whole scene through CVODE: restarts at switches, releases and impacts; samples; events.
#pragma once

#include <chrono>

#include "cvode/solver.hpp"
#include "dynamics/instants.hpp"
#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::cvode {

// What happened, for the bars of a truth. branch: the run ends unsupported at `end_s`, and is good up to there.
struct Record {
  std::vector<dynamics::Instant<Wide>> instants;
  bool branch = false;
  double end_s = 0;
};

// Samples at t_end_s k / samples; none when the observer is empty. `busy` (null: not timed) is the time of the
// integration alone: equations and CVODE's memory are made before. Never throws on a scene.
Outcome run(const Scene& scene, double t_end_s, std::int64_t samples, const Options& options, const Observer& observer,
            Record* record = nullptr, std::chrono::nanoseconds* busy = nullptr);

}  // namespace atwood::cvode
