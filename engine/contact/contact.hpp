// Runs with contacts.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// For method ids with a contact response ("rk4+event"), on scenes where contacts are possible. As run_smooth: repeats 0
// observes the run, more times it.
Outcome run_with_contacts(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                          int repeats);

}  // namespace atwood
