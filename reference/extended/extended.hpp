// The certified truth: a scene's motion in quad by two independent methods, with bars from their differences.
#pragma once

#include <cstdint>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Three runs: extrapolation of order up to 24, which gives the values, the same method at a tolerance a thousand times
// larger, and 10-stage Gauss-Legendre collocation (order 20). The bar of each value is twice the largest difference of
// the first run to the others, plus the round-off of quad. When a bar exceeds 1e-20 of the scale (the largest value of
// its kind over the run), the runs are repeated with a smaller tolerance. If a bar is still larger, the note gives the
// condition of the motion and the time from which values are not bounded.
//
// Events are looked for in the whole of each step (step_course.hpp), not at its ends; the second run shares no end of a
// step with the first but switches and events.
//
// With contacts the bars include the errors that the runs share (dynamics/shared_errors.hpp): the location of impacts,
// round-off propagated through every impact, the neglected bounces of a series, and the velocity jump at a sample
// within the half-width of an impact's time.
//
// Covers every smooth scene and, with located impacts, rigid contacts of spheres with spheres, planes and fixed
// rectangles and boxes, up to 200 unknowns. For anything else the answer is Status::unsupported with a reason. Where an
// outcome is not decided within the bars (a grazing impact, simultaneous impacts without a convention) the truth ends:
// Status::unsupported, a reason with the time, and the samples and events before it, which are certified. Never throws
// on a scene.
Truth extended_truth(const Scenario& scenario, std::int64_t samples);

// Condition of the motion: the largest growth of a relative perturbation of the initial state, with each component
// relative to the scale of its kind. When the run is short enough to perturb each component by itself this is the
// infinity norm of the flow's derivative; otherwise it is the largest growth over eight perturbations of random signs.
// In double. 0: it could not be computed.
double flow_condition(const Scene& scene, double t_end_s, std::int64_t samples);

}  // namespace atwood
