// A goal whose error is taken over several variants of its scene: other seeds of disturbed particles, other phases of
// the motion, starts that differ in the last place.
#pragma once

#include <vector>

#include "benchmarks/goals.hpp"
#include "scene/scene.hpp"

namespace atwood {

// How many variants the goal asks for, the scene itself included; at least 1.
std::int64_t variant_count(const Goal& goal);

// Variant 1, 2 .. variant_count - 1 of the scene.
//   seeds    particles disturbed by the seed k + 1
//   phases   all velocities faster by the factor 1 + k / 6400: what a step of the run meets, it meets in another phase.
//            The factor is common to all, so that the velocities of closed loops stay consistent
//   starts   every joint coordinate k units in the last place away from zero
Scenario variant_of(const Goal& goal, Scenario scenario, std::int64_t k);

// The goal's error from those of all variants: the median over seeds, the largest over phases, the root mean square
// over starts. NaN unless there are `count` of them.
double combined_error(const Goal& goal, std::vector<double> errors, std::int64_t count);

}  // namespace atwood
