// A whole scene through CVODE: restarts at switches, releases and impacts; samples; events.
#pragma once

#include "cvode/solver.hpp"
#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::cvode {

// Samples at t_end_s k / samples; none when the observer is empty. Never throws on a scene.
Outcome run(const Scene& scene, double t_end_s, std::int64_t samples, const Options& options, const Observer& observer);

}  // namespace atwood::cvode
