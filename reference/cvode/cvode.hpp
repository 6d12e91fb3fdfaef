// SUNDIALS CVODE on the reference's own equations: a method among others (with bars it is also a truth, of scenes that
// nothing better covers). Manual: Hindmarsh et al., ACM TOMS 31 (2005) 363.
#pragma once

#include <cstdint>

#include "protocol/method.hpp"
#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// cvode/adams and cvode/bdf, adaptive: `:rtol[,atol]`, 1e-10 when none is given. Impacts are located by root functions
// and the integration is restarted there, at switches and at releases.
Engine cvode_engine();

// Adams and BDF at two tolerances each. Values from the tighter Adams; the bar of each kind of value is twice the
// largest difference among the four so far in the run, and with contacts what they share (dynamics/shared_errors.hpp).
// Sphere-sphere and sphere-plane contacts. Where an outcome is not decided within the bars, or the runs disagree on an
// impact, it ends as extended_truth does. Absolute tolerances are relative to the size of each kind of value.
Truth cvode_truth(const Scenario& scenario, std::int64_t samples);

}  // namespace atwood
