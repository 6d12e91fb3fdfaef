// The in-house engine: a method, a scene and a plan in, samples and an outcome out.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// "atwood": every method of integrators/catalogue.hpp, in float, double, long double and quad.
Engine atwood_engine();

// Can two shaped bodies meet, at least one of them moving? Then a run needs a contact response.
bool contacts_possible(const Scene& scene);

// A run with the response that the id names ("impulse", "event" or "penalty"), whether or not contacts are possible.
// repeats = 0: the accuracy pass, whose samples go to `observer`. repeats > 0: one warm-up, then so many timed passes
// without observation. Unsupported, with the reason, for any other response.
Outcome run_with_contacts(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                          int repeats);

}  // namespace atwood
