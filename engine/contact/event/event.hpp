// `+event`: the run.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// As run_with_contacts, for ids with the response "event".
Outcome run_event(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats);

}  // namespace atwood
