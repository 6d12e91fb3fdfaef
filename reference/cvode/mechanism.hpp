// CVODE on the minimal coordinates of trees of joints, with the reference's own equations.
#pragma once

#include <chrono>

#include "cvode/solver.hpp"
#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::cvode {

// As run() for scenes with joints: y = coordinates and rates of the tree. Restarted at switches. Loops and ropes (which
// ida/ integrates), stops of joints and what mechanism::unsupported() names are answered with Status::unsupported.
Outcome run_mechanism(const Scene& scene, double t_end_s, std::int64_t samples, const Options& options,
                      const Observer& observer, std::chrono::nanoseconds* busy = nullptr);

}  // namespace atwood::cvode
