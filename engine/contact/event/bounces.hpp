// The end of a series of bounces.
#pragma once

#include "contact/event/impact_problem.hpp"

namespace atwood::event {

// Marks the pairs whose impact at t_s is the last of a series of bounces (ShapePair::last_bounce), after the impacts
// have been solved once. True: there are such pairs.
template <class S> bool find_last_bounces(EventRun<S>& run, const ImpactProblem<S>& problem, S t_s);

}  // namespace atwood::event
