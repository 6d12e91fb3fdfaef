// The impacts of one instant.
#pragma once

#include "contact/event/run.hpp"

namespace atwood::event {

// All impacts at states.y, then the active set and projection. False: the run ends; report.outcome says why.
template <class S> bool resolve_impacts(EventRun<S>& run, S t_s);

}  // namespace atwood::event
