// Motion with impacts and rest.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// For ids with a response on scenes where contacts are possible. As run_smooth: repeats = 0 observes, else times.
Outcome run_with_contacts(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                          int repeats);

}  // namespace atwood
