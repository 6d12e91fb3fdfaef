// The response "+impulse": time stepping with contacts solved at the level of velocities (stepping/world.hpp).
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// As run_with_contacts, for ids with the response "impulse", in float and double.
Outcome run_impulse(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats);

}  // namespace atwood
