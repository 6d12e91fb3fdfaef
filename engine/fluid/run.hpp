// Runs of fluids: a system of particles and a stepper, taken through the output times of a plan.
#pragma once

#include "fluid/particle_system.hpp"
#include "integrators/stepper.hpp"
#include "protocol/method.hpp"

namespace atwood::fluid {

// A run of a scene with fluids by the response that the id names. repeats = 0: the accuracy pass, whose samples go to
// `observer`. repeats > 0: one warm-up, then so many timed passes without observation. Refused with the reason
// (unsupported): what the response or the scheme cannot keep, and equal steps beyond the stability limit.
Outcome run_fluid(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats);

// The marching of it: equal steps, or adaptive ones where the id carries a tolerance. `id` is the integrator's part.
// A particle that is lost or not finite ends the run, with where and when.
template <class S>
Outcome march(ParticleSystem<S>& particles, Stepper<S>& stepper, const MethodId& id, const Plan& plan,
              const Observer& observer, int repeats);

}  // namespace atwood::fluid
