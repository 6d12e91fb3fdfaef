// CVODE on the minimal coordinates of trees of joints, with the reference's own equations.
#pragma once

#include <chrono>

#include "cvode/solver.hpp"
#include "protocol/sample.hpp"
#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood::cvode {

// trees: loops and ropes are refused, as of the methods. constraints: they are held by their multipliers alone (index
// 1, without projection: drift off the constraints is part of a run's error). A run then ends by name,
// Status::unsupported, where a rope is slack, leaves its pulley or is drawn to it, and where the constraints lose rank.
enum class Coverage { trees, constraints };

// As run() for scenes with joints: y = coordinates and rates of the tree. Restarted at switches. Stops of joints and
// what mechanism::unsupported() names are answered with Status::unsupported. `end_s`: where a run ended by name; the
// samples before it are good.
Outcome run_mechanism(const Scene& scene, double t_end_s, std::int64_t samples, const Options& options,
                      const Observer& observer, std::chrono::nanoseconds* busy = nullptr,
                      Coverage coverage = Coverage::trees, double* end_s = nullptr);

// Adams and BDF at two tolerances each: see cvode_truth(). The bar of a value is twice the largest difference of its
// kind among the four runs up to then, plus 1e-13 of the kind's scale.
Truth mechanism_truth(const Scenario& scenario, std::int64_t samples);

}  // namespace atwood::cvode
