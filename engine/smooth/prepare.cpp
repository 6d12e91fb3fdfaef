#include <type_traits>

#include "integrators/families.hpp"
#include "integrators/maximal_coordinates.hpp"
#include "protocol/refusal.hpp"
#include "smooth/run.hpp"

namespace atwood {
namespace {

// How rates are computed, from a method's settings.
Result<ModelOptions> model_options(const MethodId& id) {
  ModelOptions options;
  const MethodInfo* info = find_integrator(id.scheme);
  if (info == nullptr) return options;
  const Result<Settings> settings = merged_settings(*info, id.overrides);
  if (!settings) return settings.fault();
  if (settings->count("projection") > 0)
    options.project_constraints = std::get<std::string>(settings->at("projection")) != "none";
  if (settings->count("gravity") == 0) return options;
  const auto& gravity = std::get<std::string>(settings->at("gravity"));
  if (gravity == "direct") options.gravity.sum = GravityOptions::Sum::direct;
  else if (gravity == "tree") options.gravity.sum = GravityOptions::Sum::tree;
  options.gravity.opening = std::get<double>(settings->at("opening"));
  options.threads = static_cast<int>(std::get<std::int64_t>(settings->at("threads")));
  return options;
}

// Whether mechanisms move in the coordinates of all their bodies.
bool in_all_bodies(const MethodId& id) {
  if (steps_maximal_coordinates(id.scheme)) return true;
  const auto chosen = id.overrides.find("coordinates");
  return chosen != id.overrides.end() && chosen->second == SettingValue(std::string("maximal"));
}

}  // namespace

template <class S>
Simulation<S> prepare(const MethodId& id, const Scene& scene, std::unique_ptr<StatefulForce<S>> added,
                      const std::string& what) {
  Simulation<S> simulation;
  const Result<ModelOptions> options = model_options(id);
  if (!options) {
    simulation.outcome = refused(options.fault());
    return simulation;
  }
  const bool maximal = in_all_bodies(id) && !(scene.joints.empty() && scene.ropes.empty());
  const Result<Scene> free = maximal ? in_maximal_coordinates(scene, id.scheme) : Scene{};
  if (!free) {
    simulation.outcome = refused(free.fault());
    return simulation;
  }
  simulation.model = std::make_unique<RigidModel<S>>(maximal ? *free : scene, *options);
  RigidModel<S>& model = *simulation.model;
  if (!model.unsupported().empty()) {
    simulation.outcome = refused(model.unsupported());
    return simulation;
  }
  if (added != nullptr) {
    simulation.stateful_force = added.get();
    model.add_term(std::move(added), what);
  }
  Result<std::unique_ptr<Stepper<S>>> stepper = make_stepper(id.scheme, model, id.overrides);
  if (!stepper) {
    simulation.outcome = refused(stepper.fault());
    return simulation;
  }
  simulation.stepper = std::move(*stepper);
  simulation.free_flight = make_free_flight(model, simulation.stepper->weights());
  simulation.y.resize(model.state_size());
  simulation.y_new.resize(model.state_size());
  model.initial_state(simulation.y.data());
  return simulation;
}

// In the wider of double and S, then narrowed.
template <class S> S time_at(const Plan& plan, std::int64_t n) {
  using Clock = std::conditional_t<std::is_same_v<S, float>, double, S>;
  return S(step_begin_s<Clock>(plan, n));
}

template <class S>
void observe(RigidModel<S>& model, const Plan& plan, std::int64_t k, const S* y, Sample& sample,
             const Observer& observer, StatefulForce<S>* stateful_force) {
  if (!observer.sample) return;
  using Clock = std::conditional_t<std::is_same_v<S, float>, double, S>;
  const Clock t_s = Clock(plan.t_end_s) * Clock(k) / Clock(plan.samples);
  sample.t_s = t_s;
  model.write(S(t_s), y, sample);
  if (stateful_force != nullptr) stateful_force->report(model.motion(S(t_s), y), sample, observer);
  observer.sample(sample);
}

template <class S> bool healthy(const S* y, int size, S scale, S t_s, Outcome& outcome) {
  for (int i = 0; i < size; ++i) {
    if (real::is_finite(y[i]) && real::abs(y[i]) <= S(1e12) * scale) continue;
    outcome.status = real::is_finite(y[i]) ? Status::diverged : Status::not_finite;
    outcome.reason = (real::is_finite(y[i]) ? "the state is 1e12 times its first size at t = " : "not finite at t = ") +
                     format_double(static_cast<double>(t_s)) + " s";
    return false;
  }
  return true;
}

template <class S> S state_scale(const S* y, int size) {
  S scale = S(1);
  for (int i = 0; i < size; ++i) scale = real::max(scale, real::abs(y[i]));
  return scale;
}

#define ATWOOD_SIMULATION(S)                                                                              \
  template Simulation<S> prepare<S>(const MethodId&, const Scene&, std::unique_ptr<StatefulForce<S>>,     \
                                    const std::string&);                                                  \
  template S time_at<S>(const Plan&, std::int64_t);                                                       \
  template void observe<S>(RigidModel<S>&, const Plan&, std::int64_t, const S*, Sample&, const Observer&, \
                           StatefulForce<S>*);                                                            \
  template bool healthy<S>(const S*, int, S, S, Outcome&);                                                \
  template S state_scale<S>(const S*, int);
ATWOOD_SIMULATION(float)
ATWOOD_SIMULATION(double)
ATWOOD_SIMULATION(long double)
ATWOOD_SIMULATION(Quad)
#undef ATWOOD_SIMULATION

}  // namespace atwood
