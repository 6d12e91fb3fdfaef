#include "simulation.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "collision/query.hpp"
#include "contact/contact.hpp"
#include "contact/options.hpp"
#include "contact/penalty.hpp"
#include "scene/contact_laws.hpp"

namespace atwood {
namespace {

Outcome refuse(const std::string& reason) { return {Status::unsupported, reason, 0, 0, {}}; }

std::string method_fault(const MethodId& id) {
  const MethodInfo* info = find_integrator(id.scheme);
  if (info == nullptr) return "atwood has no method `" + id.scheme + "`";
  if (id.rtol && !info->adaptive) return info->id + " takes equal steps, no tolerance";
  if (const auto settings = merged_settings(*info, id.overrides); !settings) return settings.fault().reason;
  if (!id.response.empty() && find_response(id.response) == nullptr)
    return "atwood has no contact response `" + id.response + "`";
  return "";
}

// How rates are computed, from a method's settings.
Result<ModelOptions> model_options(const MethodId& id) {
  ModelOptions options;
  const MethodInfo* info = find_integrator(id.scheme);
  if (info == nullptr) return options;
  const Result<Settings> settings = merged_settings(*info, id.overrides);
  if (!settings) return settings.fault();
  if (settings->count("gravity") == 0) return options;
  const auto& gravity = std::get<std::string>(settings->at("gravity"));
  if (gravity == "direct") options.gravity.sum = GravityOptions::Sum::direct;
  else if (gravity == "tree") options.gravity.sum = GravityOptions::Sum::tree;
  options.gravity.opening = std::get<double>(settings->at("opening"));
  options.threads = static_cast<int>(std::get<std::int64_t>(settings->at("threads")));
  return options;
}

Outcome run_in_contact(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                       int repeats) {
  if (id.response == "penalty") return run_with_penalty(id, scene, plan, observer, repeats);
  const auto gives_way = [](const PairLaw& law) { return law.contact_law != ContactLaw::rigid; };
  if (!id.response.empty() && std::ranges::any_of(laws_in_play(scene), gives_way))
    return refuse("contacts of this scene give way by a law of their own: +penalty is for them");
  if (id.response.empty())
    return refuse("atwood/" + id.scheme + " has no contact response; use +impulse, +event or +penalty");
  return run_with_contacts(id, scene, plan, observer, repeats);
}

Outcome run(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (const std::string fault = method_fault(integrator_part(id)); !fault.empty()) return refuse(fault);
  if (contacts_possible(scene)) return run_in_contact(id, scene, plan, observer, repeats);
  const MethodId smooth = integrator_part(id);  // where nothing can touch, a response's settings are nobody's
  if (id.scalar.empty() || id.scalar == "double") return run_smooth<double>(smooth, scene, plan, observer, repeats);
  if (id.scalar == "float") return run_smooth<float>(smooth, scene, plan, observer, repeats);
  if (id.scalar == "long-double") return run_smooth<long double>(smooth, scene, plan, observer, repeats);
  if (id.scalar == "quad") return run_smooth<Quad>(smooth, scene, plan, observer, repeats);
  return refuse("atwood does not compute in `" + id.scalar + "`; use float, double, long-double or quad");
}

}  // namespace

Engine atwood_engine() {
  return {"atwood", "0.1.0", "double", integrator_catalogue(), run, true, contact_responses(), find_scene_contacts};
}

bool contacts_possible(const Scene& scene) {
  int shaped = 0, moving = 0;
  for (const Body& body : scene.bodies) {
    if (std::holds_alternative<std::monostate>(body.shape)) continue;
    ++shaped;
    if (!body.fixed) ++moving;
  }
  return shaped >= 2 && moving >= 1;
}

template <class S>
Simulation<S> prepare(const MethodId& id, const Scene& scene, std::unique_ptr<RememberingTerm<S>> added,
                      const std::string& what) {
  Simulation<S> simulation;
  const Result<ModelOptions> options = model_options(id);
  if (!options) {
    simulation.outcome = refuse(options.fault().reason);
    return simulation;
  }
  simulation.model = std::make_unique<RigidModel<S>>(scene, *options);
  RigidModel<S>& model = *simulation.model;
  if (!model.unsupported().empty()) {
    simulation.outcome = refuse(model.unsupported());
    return simulation;
  }
  if (added != nullptr) {
    simulation.memory = added.get();
    model.add_term(std::move(added), what);
  }
  std::string why;
  simulation.stepper = make_stepper<S>(id.scheme, model, why, id.overrides);
  if (simulation.stepper == nullptr) {
    simulation.outcome = refuse(why);
    return simulation;
  }
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
             const Observer& observer, RememberingTerm<S>* memory) {
  if (!observer.sample) return;
  using Clock = std::conditional_t<std::is_same_v<S, float>, double, S>;
  const Clock t_s = Clock(plan.t_end_s) * Clock(k) / Clock(plan.samples);
  sample.t_s = t_s;
  model.write(S(t_s), y, sample);
  if (memory != nullptr) memory->tell(model.motion(S(t_s), y), sample, observer);
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
  template Simulation<S> prepare<S>(const MethodId&, const Scene&, std::unique_ptr<RememberingTerm<S>>,   \
                                    const std::string&);                                                  \
  template S time_at<S>(const Plan&, std::int64_t);                                                       \
  template void observe<S>(RigidModel<S>&, const Plan&, std::int64_t, const S*, Sample&, const Observer&, \
                           RememberingTerm<S>*);                                                          \
  template bool healthy<S>(const S*, int, S, S, Outcome&);                                                \
  template S state_scale<S>(const S*, int);
ATWOOD_SIMULATION(float)
ATWOOD_SIMULATION(double)
ATWOOD_SIMULATION(long double)
ATWOOD_SIMULATION(Quad)
#undef ATWOOD_SIMULATION

}  // namespace atwood
