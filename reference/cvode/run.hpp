// Integration of a whole scene with CVODE: restarts at switches, releases and impacts; samples; events.
#pragma once

#include <chrono>

#include "cvode/solver.hpp"
#include "dynamics/instants.hpp"
#include "protocol/ragged_array.hpp"
#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::cvode {

// What happened, for the bars of a truth. valid_until_failure: the run ended unsupported at `end_s` and is valid
// before.
struct Record {
  RaggedArray<double> states;  // of the samples, in dynamics::layout
  std::vector<dynamics::Instant<Wide>> instants;
  bool valid_until_failure = false;
  double end_s = 0;
};

// Samples at t_end_s k / samples; none when the observer is empty. `busy` (null: not timed) receives the time of the
// integration alone, without the construction of the equations and of CVODE's memory. What is not covered is answered
// with Status::unsupported and a reason. Never throws on a scene.
Outcome run(const Scene& scene, double t_end_s, std::int64_t samples, const Options& options, const Observer& observer,
            Record* record = nullptr, std::chrono::nanoseconds* busy = nullptr);

}  // namespace atwood::cvode
