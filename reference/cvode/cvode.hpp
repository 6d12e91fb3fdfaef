// SUNDIALS CVODE on the reference's own equations: a method among others, and a truth for scenes that no better truth
// covers. A. C. Hindmarsh et al., SUNDIALS, ACM Trans. Math. Softw. 31 (2005) 363.
#pragma once

#include <cstdint>

#include "protocol/method.hpp"
#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// The methods cvode/adams and cvode/bdf, adaptive: `:rtol[,atol]`, 1e-10 when none is given. Impacts are located by
// root functions; the integration is restarted at impacts, switches and releases.
Engine cvode_engine();

// Four runs: Adams and BDF at two tolerances each. The values are those of Adams at the smaller tolerance; the bar of
// each kind of value is twice the largest difference among the four runs up to that time, plus, with contacts, the
// errors that the runs share (dynamics/shared_errors.hpp). Contacts: spheres with spheres, planes and fixed rectangles
// and boxes. Where an outcome is not decided within the bars, or the runs disagree on an impact, the truth ends as
// extended_truth does: Status::unsupported, a reason with the time, and the samples and events before it. Absolute
// tolerances are relative to the size of each kind of value. Mechanisms are integrated in the coordinates of a spanning
// tree, loops and ropes by their multipliers; stops of joints are refused. Never throws on a scene.
Truth cvode_truth(const Scenario& scenario, std::int64_t samples);

}  // namespace atwood
