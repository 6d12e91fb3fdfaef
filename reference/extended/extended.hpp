// The certified truth: a scene's motion in quad by two unrelated methods, and how far they are apart.
#pragma once

#include <cstdint>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Values by extrapolation of order up to 24. The bar of each value is the largest difference among that run, the same
// method at a tolerance a thousand times wider, and 10-stage Gauss-Legendre collocation (order 20), plus the round-off
// of quad. When a bar exceeds 1e-20 of the scale (the largest value of its kind over the run) the three are run again,
// closer; if that does not help the note says what the motion's conditioning allows, and from when on nothing is
// bounded.
//
// With contacts the bars also hold what the runs share (dynamics/shared_errors.hpp): the location of impacts, round-off
// grown through every impact, the bounces that a series sums up, and at a sample within an impact's time bar the jump.
//
// Covers every smooth scene and, with located impacts, smooth contacts of spheres with spheres and planes, up to 200
// unknowns. Anything else is answered with Status::unsupported and a reason. Where an outcome is not decided within the
// bars (a graze, impacts at one instant without a convention) the truth ends: Status::unsupported, a reason with the
// time, and the samples and events before it, which are certified. Never throws on a scene.
Truth extended_truth(const Scenario& scenario, std::int64_t samples);

// Largest growth of a relative perturbation of the initial state, each component perturbed by its kind's scale: a
// bound for the sum over all components (the infinity norm of the flow's derivative) where the run is short enough to
// try each one, a sample of random signs where it is not. In double. 0: could not be computed.
double flow_condition(const Scene& scene, double t_end_s, std::int64_t samples);

}  // namespace atwood
