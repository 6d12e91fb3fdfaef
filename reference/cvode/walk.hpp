// CVODE along a scene's whole motion: samples, restarts at switches and releases, impacts, rest.
#pragma once

#include "cvode/solver.hpp"
#include "protocol/method.hpp"

namespace atwood::cvode {

// Why CVODE's adapter does not cover this scene; empty when it does.
std::string refusal(const Scene& scene);

// samples = 0 goes straight to the end (the timed pass). `outcome` carries evaluations and steps.
Outcome walk(const Scene& scene, double t_end_s, std::int64_t samples, Formula formula, const Tolerance& tolerance,
             const Observer& observer);

}  // namespace atwood::cvode
