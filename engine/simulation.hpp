// The in-house engine: a method, a scene and a plan in, samples and an outcome out.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "integrators/catalogue.hpp"
#include "integrators/stepper.hpp"
#include "protocol/method.hpp"
#include "rigid/free_flight.hpp"
#include "rigid/model.hpp"

namespace atwood {

// "atwood": every method of integrators/catalogue.hpp, in float, double, long double and quad.
Engine atwood_engine();

// Can two shaped bodies meet, at least one of them moving? Then a run needs a contact response.
bool contacts_possible(const Scene& scene);

// ---- one run, in one scalar -----------------------------------------------------------------------------------
// A model with its stepper, ready to run. `outcome.status` is unsupported, with the reason, when it is not.
template <class S> struct Simulation {
  std::unique_ptr<RigidModel<S>> model;
  std::unique_ptr<Stepper<S>> stepper;
  std::unique_ptr<FreeFlight<S>> free_flight;  // null: no force-free scene, or no method whose steps can be fused
  std::vector<S> y, y_new;  // the state, and room for the next one
  Outcome outcome;
};
template <class S> Simulation<S> prepare(const MethodId& id, const Scene& scene);

// When step n begins (protocol/sample.hpp): no accumulation.
template <class S> S time_at(const Plan& plan, std::int64_t n);

// Sample k of the plan, at t = t_end k / samples, from the state y.
template <class S> void observe(RigidModel<S>& model, const Plan& plan, std::int64_t k, const S* y, Sample& sample,
                                const Observer& observer);

// Is the state fit to go on? Otherwise sets the outcome: not finite, or diverged (a component above 1e12 `scale`).
template <class S> bool healthy(const S* y, int size, S scale, S t_s, Outcome& outcome);
template <class S> S state_scale(const S* y, int size);  // largest component, at least 1

// Smooth motion: equal steps, or adaptive ones where the id carries a tolerance. Accuracy pass for repeats = 0; timed
// pass (one warm-up, then `repeats` timed runs without observation) otherwise.
template <class S>
Outcome run_smooth(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats);

// Motion with impacts and rest lives in contact/contact.hpp:
//   Outcome run_with_contacts(const MethodId&, const Scene&, const Plan&, const Observer&, int repeats);
// It is called for ids with a response ("impulse", "event", ...) on scenes where contacts are possible.

}  // namespace atwood
