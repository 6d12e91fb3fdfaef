#include "contact/contact.hpp"

#include <chrono>

#include "contact/options.hpp"
#include "contact/response.hpp"
#include "contact/stepping/run.hpp"
#include "simulation.hpp"

namespace atwood {

namespace {

template <class S> using StepWithContacts = bool (*)(ContactRun<S>&, S, S);

// A cut step needs a method that reproduces itself from any state; a step that starts at an impact has no past.
template <class S> StepWithContacts<S> response_of(const std::string& name) {
  if (name == "event") return &step_with_events<S>;
  return nullptr;
}

Outcome unsupported(const std::string& reason) { return {Status::unsupported, reason, 0, 0, {}}; }

// From the initial state to the end, with or without looking.
template <class S>
Outcome run_once(ContactRun<S>& run, StepWithContacts<S> step, const Plan& plan, const Observer& observer) {
  RigidModel<S>& model = run.model;
  run.outcome = {};
  run.resting.clear();
  run.h_next_s = S(0);
  run.observer = &observer;
  model.initial_state(run.y.data());
  model.system().evaluations = 0;
  const S scale = state_scale(run.y.data(), model.state_size());
  const std::int64_t stride = plan.steps / plan.samples;
  Sample sample;
  if (observer.sample) observe(model, plan, 0, run.y.data(), sample, observer);
  auto before = std::chrono::steady_clock::now();
  for (std::int64_t n = 0; n < plan.steps; ++n) {
    const S from_s = time_at<S>(plan, n), to_s = time_at<S>(plan, n + 1);
    model.select_interval(from_s, to_s);
    if (!step(run, from_s, to_s - from_s)) {
      if (run.outcome.status == Status::ok) run.outcome = {Status::diverged, "an implicit step has no solution", 0, 0, {}};
      break;
    }
    ++run.outcome.steps_taken;
    if (observer.profile != nullptr) {
      const auto after = std::chrono::steady_clock::now();
      observer.profile->step_ns.push_back(std::chrono::duration_cast<std::chrono::nanoseconds>(after - before).count());
      before = after;
    }
    if ((n + 1) % stride != 0) continue;
    if (!healthy(run.y.data(), model.state_size(), scale, to_s, run.outcome)) break;
    if (observer.sample) observe(model, plan, (n + 1) / stride, run.y.data(), sample, observer);
  }
  run.outcome.rate_evaluations = model.system().evaluations;
  return run.outcome;
}

template <class S>
Outcome run_in(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const StepWithContacts<S> step = response_of<S>(id.response);
  if (!step) return unsupported("atwood has no contact response `+" + id.response + "`; it has +impulse and +event");
  Simulation<S> simulation = prepare<S>(integrator_part(id), scene);
  if (simulation.outcome.status != Status::ok) return simulation.outcome;
  std::string why;
  ContactRun<S> run = make_contact_run(*simulation.model, *simulation.stepper, scene, why);
  if (!why.empty()) return unsupported(why);
  if (id.rtol) {
    run.rtol = S(*id.rtol);
    run.atol = S(id.atol.value_or(*id.rtol / 100));
  }
  if (repeats <= 0) return run_once(run, step, plan, observer);

  const Observer nobody;
  Outcome outcome = run_once(run, step, plan, nobody);  // warm-up
  for (int i = 0; i < repeats && outcome.status == Status::ok; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const Outcome timed = run_once(run, step, plan, nobody);
    const auto busy = std::chrono::steady_clock::now() - start;
    outcome.busy_ns.push_back(std::chrono::duration_cast<std::chrono::nanoseconds>(busy).count());
    if (timed.status != Status::ok) outcome = timed;
  }
  return outcome;
}

}  // namespace

Outcome run_with_contacts(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (id.response == "impulse") return run_impulse(id, scene, plan, observer, repeats);
  if (id.scalar == "float") return run_in<float>(id, scene, plan, observer, repeats);
  if (id.scalar.empty() || id.scalar == "double") return run_in<double>(id, scene, plan, observer, repeats);
  if (id.scalar == "long-double") return run_in<long double>(id, scene, plan, observer, repeats);
  return unsupported("atwood's contacts run in float, double and long-double, not in " + id.scalar);
}

}  // namespace atwood
