// Runs of smooth motion: a model and its stepper, taken through the output times of a plan.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "forces/stateful_force.hpp"
#include "integrators/adaptive.hpp"
#include "integrators/catalogue.hpp"
#include "integrators/free_flight.hpp"
#include "protocol/fault.hpp"
#include "protocol/method.hpp"
#include "rigid/model.hpp"

namespace atwood {

// A model with its stepper, ready to run. `outcome.status` is unsupported, with the reason, when it is not.
template <class S> struct Simulation {
  std::unique_ptr<RigidModel<S>> model;
  std::unique_ptr<Stepper<S>> stepper;
  std::unique_ptr<FreeFlight<S>> free_flight;  // null: forces besides uniform gravity, or steps that cannot be fused
  StatefulForce<S>* stateful_force = nullptr;  // owned by the model; null: no force has internal state
  std::vector<S> y, y_new;                     // the state, and room for the next one
  Outcome outcome;
};
// `added`: a force besides the scene's (null: none); `what` names it in refusals ("contact forces").
template <class S>
Simulation<S> prepare(const MethodId& id, const Scene& scene, std::unique_ptr<StatefulForce<S>> added = nullptr,
                      const std::string& what = "");

// The time [s] at which step n begins (protocol/sample.hpp): computed from n, so that no error accumulates.
template <class S> S time_at(const Plan& plan, std::int64_t n);

// Passes sample k of the plan, at t = t_end k / samples, from the state y to `observer`.
template <class S>
void observe(RigidModel<S>& model, const Plan& plan, std::int64_t k, const S* y, Sample& sample,
             const Observer& observer, StatefulForce<S>* stateful_force = nullptr);

// Are all `size` components finite and at most 1e12 `scale`? If not, sets the outcome: not finite, or diverged.
template <class S> bool healthy(const S* y, int size, S scale, S t_s, Outcome& outcome);
template <class S> S state_scale(const S* y, int size);  // largest component, at least 1

// Why a plan cannot be run, or why a tolerance is invalid.
std::optional<Fault> plan_fault(const MethodId& id, const Plan& plan);
// Why no error estimate in the scalar S can meet the tolerance of an id. None where the method chooses its own steps.
template <class S> std::optional<Fault> tolerance_fault(const MethodId& id, const Stepper<S>& stepper);
// The reason of a run that ends at t_s because a step's implicit equations were not solved, with the last residual.
std::string unsolved_step(const SolverTallies& solvers, double t_s);
// The step control's settings of an id whose settings have been checked; the standard ones for a scheme without them.
StepLimits step_limits(const MethodId& id);

// Equal steps, or adaptive ones where the id carries a tolerance. repeats = 0: the accuracy pass, whose samples go to
// `observer`. repeats > 0: one warm-up, then so many timed passes without observation. The outcome says why a run was
// refused or broken off.
template <class S>
Outcome run_smooth(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats);
// The same of what prepare() made.
template <class S>
Outcome run_prepared(Simulation<S>& simulation, const MethodId& id, const Plan& plan, const Observer& observer,
                     int repeats);

}  // namespace atwood
