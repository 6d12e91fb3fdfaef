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

// A force that remembers: within a step it depends on the state alone, and from one accepted step to the next it
// learns.
template <class S> class RememberingTerm : public ForceTerm<S> {
 public:
  virtual void begin(const Motion<S>& motion) = 0;  // the start of a run: nothing is remembered
  // After an accepted step. True: the forces at this very state are others than before (cached rates are stale).
  virtual bool accept(const Motion<S>& motion) = 0;
  // What acts at a sample, into sample.contacts; what has happened since the last one, to observer.event.
  virtual void tell(const Motion<S>& motion, Sample& sample, const Observer& observer) = 0;
};

// ---- one run, in one scalar -----------------------------------------------------------------------------------
// A model with its stepper, ready to run. `outcome.status` is unsupported, with the reason, when it is not.
template <class S> struct Simulation {
  std::unique_ptr<RigidModel<S>> model;
  std::unique_ptr<Stepper<S>> stepper;
  std::unique_ptr<FreeFlight<S>> free_flight;  // null: no force-free scene, or no method whose steps can be fused
  RememberingTerm<S>* memory = nullptr;        // of the model's terms; null: none of them remembers
  std::vector<S> y, y_new;                     // the state, and room for the next one
  Outcome outcome;
};
// `added`: a force besides the scene's (null: none), named `what`.
template <class S>
Simulation<S> prepare(const MethodId& id, const Scene& scene, std::unique_ptr<RememberingTerm<S>> added = nullptr,
                      const std::string& what = "");

// When step n begins (protocol/sample.hpp): no accumulation.
template <class S> S time_at(const Plan& plan, std::int64_t n);

// Sample k of the plan, at t = t_end k / samples, from the state y.
template <class S>
void observe(RigidModel<S>& model, const Plan& plan, std::int64_t k, const S* y, Sample& sample,
             const Observer& observer, RememberingTerm<S>* memory = nullptr);

// Is the state fit to go on? Otherwise sets the outcome: not finite, or diverged (a component above 1e12 `scale`).
template <class S> bool healthy(const S* y, int size, S scale, S t_s, Outcome& outcome);
template <class S> S state_scale(const S* y, int size);  // largest component, at least 1

// Smooth motion: equal steps, or adaptive ones where the id carries a tolerance. Accuracy pass for repeats = 0; timed
// pass (one warm-up, then `repeats` timed runs without observation) otherwise.
template <class S>
Outcome run_smooth(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats);
// The same of what prepare() made.
template <class S>
Outcome run_prepared(Simulation<S>& simulation, const MethodId& id, const Plan& plan, const Observer& observer,
                     int repeats);

// Motion with impacts and rest lives in contact/contact.hpp:
//   Outcome run_with_contacts(const MethodId&, const Scene&, const Plan&, const Observer&, int repeats);
// It is called for ids with a response ("impulse", "event", ...) on scenes where contacts are possible.

}  // namespace atwood
