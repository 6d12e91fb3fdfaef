// `+penalty`: compliant contacts as springs and dashpots, integrated by any method.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// As run_smooth, with contact forces among the forces (penalty_force.hpp). Equal steps beyond the method's stability
// limit on the stiffest contact are refused, with that limit.
Outcome run_with_penalty(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                         int repeats);

}  // namespace atwood
