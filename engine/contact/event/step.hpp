// One step of `+event`.
#pragma once

#include "contact/event/run.hpp"

namespace atwood::event {

// From t_s to t_s + h_s, states.y in place. False: the run ends; report.outcome says why, unless an implicit step has
// no solution.
template <class S> bool step_with_events(EventRun<S>& run, S t_s, S h_s);

}  // namespace atwood::event
