#include "contact/event/event.hpp"

#include <algorithm>
#include <chrono>

#include "contact/event/run.hpp"
#include "contact/options.hpp"
#include "simulation.hpp"

namespace atwood {

namespace event {
namespace {

Outcome unsupported(const std::string& reason) { return {Status::unsupported, reason, 0, 0, {}}; }

// The scene's convention for simultaneous impacts, if it names one, is followed; else the setting.
Result<EventOptions> with_convention(const MethodId& id, const Scene& scene, EventOptions options) {
  if (scene.simultaneous_impacts == SimultaneousImpacts::unspecified) return options;
  const bool together = scene.simultaneous_impacts == SimultaneousImpacts::together;
  if (id.overrides.count("simultaneous") > 0 && together != options.together)
    return Fault{Blame::input, std::string("+event: simultaneous=") + (together ? "sequential" : "together") +
                                   " contradicts the scene, whose simultaneous_impacts is `" +
                                   (together ? "together" : "sequential") + "`"};
  options.together = together;
  return options;
}

Result<EventOptions> read_options(const MethodId& id, const Scene& scene) {
  EventOptions options;
  const Result<Settings> settings = response_settings(id);
  if (!settings) return settings.fault();
  const auto& restitution = std::get<std::string>(settings->at("restitution"));
  if (restitution == "poisson") options.restitution = Restitution::poisson;
  else if (restitution == "stronge") options.restitution = Restitution::stronge;
  options.together = std::get<std::string>(settings->at("simultaneous")) == "together";
  return with_convention(id, scene, options);
}

template <class S> void find_winds(EventRun<S>& run, const Scene& scene) {
  for (const Force& force : scene.forces) {
    const auto* drag = std::get_if<QuadraticDrag>(&force);
    if (!drag) continue;
    for (const int body : drag->bodies)
      if (run.model.offset(body) >= 0) run.winds.push_back({body, narrow3<S>(drag->wind_m_per_s)});
  }
}

// A method that takes forces apart, or knows them as series, never asks for the rates into which contact forces go.
template <class S> bool asks_for_rates(EventRun<S>& run) {
  run.model.initial_state(run.y.data());
  run.model.select_interval(S(0), S(0));
  run.wrapped_calls = 0;
  run.model.system().evaluations = 0;
  run.stepper.step(S(0), S(0x1p-20), run.y.data(), run.y_new.data());
  return run.wrapped_calls > 0 && run.wrapped_calls == run.model.system().evaluations;
}

template <class S> void prepare_run(EventRun<S>& run, const MethodId& id, const Scene& scene) {
  const auto size = static_cast<std::size_t>(run.model.state_size());
  for (auto* y : {&run.y, &run.y_new, &run.y_probe, &run.y_kept, &run.dydt}) y->resize(size);
  run.model.initial_state(run.y.data());
  const auto bodies = static_cast<std::size_t>(run.model.body_count());
  run.poses.resize(bodies);
  run.moves.resize(bodies);
  run.round.resize(bodies);
  for (auto* v : {&run.travel, &run.excursions}) v->resize(bodies);
  for (int i = 0; i < run.model.body_count(); ++i) {
    const BodyState<S> state = run.model.body(i, run.y.data());
    Pose<S>& pose = run.poses[i];
    pose.p = state.p_WB;
    const Vec3<S> axes[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};
    for (int k = 0; k < 3; ++k) pose.axis[k] = rotate(state.q_WB, axes[k]);
    const MassProperties<S>& mass = run.model.mass(i);
    run.round[i] = run.model.offset(i) >= 0 && run.model.rotates(i) && mass.diagonal &&
                   mass.I_row[0].x == mass.I_row[1].y && mass.I_row[0].x == mass.I_row[2].z;
  }
  find_pairs(run, scene);
  find_winds(run, scene);
  hold_inverses(run);
  for (auto* v : {&run.free_acceleration, &run.acceleration}) v->resize(bodies);
  run.touches.resize(bodies);
  run.loaded.resize(bodies);
  run.near.reserve(run.pairs.size());
  run.contact_bodies.reserve(bodies);
  run.hits.reserve(run.features.size());
  run.contacts.reserve(run.features.size());
  run.contacts_before.reserve(run.features.size());
  run.contacts_guessed.reserve(run.features.size());
  run.standing_before.reserve(run.features.size());
  run.pending.reserve(run.features.size());
  wrap_rates(run);
  if (id.rtol) {
    run.rtol = S(*id.rtol);
    run.atol = S(id.atol.value_or(*id.rtol / 100));
    run.stepper.set_tolerance(run.rtol, run.atol);
  }
  if (!asks_for_rates(run)) {
    std::string why;
    run.substitute = make_stepper<S>(id.rtol ? "dopri5" : "rk4", run.model, why, {});
  }
  if (std::any_of(run.pairs.begin(), run.pairs.end(), [](const ShapePair<S>& pair) { return pair.friction > S(0); })) {
    std::string why;
    run.fine = make_stepper<S>("dop853", run.model, why, {});
  }
}

template <class S> void restart(EventRun<S>& run, const Plan& plan) {
  run.outcome = {};
  run.contacts.clear();
  run.carrying = 0;
  run.inconsistent = -1;
  run.struck_s = S(-1);
  run.strikes = 0;
  run.starts = true;
  run.slip_ends = false;
  run.has_factors = false;
  run.modes = 0;
  run.seen_epoch = -1;
  run.h_next_s = S(0);
  run.speed_scale = norm(run.model.uniform_gravity()) * S(plan.t_end_s) / S(plan.steps);
  std::fill(run.travel.begin(), run.travel.end(), S(0));
  for (Feature<S>& feature : run.features) {
    feature.lasting = false;
    feature.over_triangle = 0;  // a run's bits do not depend on the one before
  }
  for (ShapePair<S>& pair : run.pairs) {
    pair.look_again_at = S(0);
    pair.known_at = -1;
    pair.ends = false;
    pair.ends_s = S(0);
  }
  run.model.initial_state(run.y.data());
  run.model.system().evaluations = 0;
  ++run.model.system().epoch;
}

std::array<double, 3> as_doubles(const auto& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

// Forces at this instant, of the law that held up to it.
template <class S> void write_contacts(EventRun<S>& run, S t_s, Sample& sample) {
  sample.contacts.clear();
  if (run.carrying == 0) return;
  run.free_rate_of(run.free_context, t_s, run.y.data(), run.dydt.data());
  contact_rates(run, t_s, run.y.data(), run.dydt.data());
  for (const Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    const Feature<S>& feature = run.features[contact.feature];
    const ShapePair<S>& pair = run.pairs[feature.pair];
    const S sign = feature.knob_body == pair.b ? S(1) : S(-1);  // of what acts on b
    sample.contacts.push_back({pair.a, pair.b, as_doubles(contact.sight.x), as_doubles(sign * contact.sight.normal),
                               static_cast<double>(contact.sight.gap), static_cast<double>(contact.normal_N),
                               as_doubles(sign * contact.friction_N)});
  }
}

template <class S> Outcome run_once(EventRun<S>& run, const Plan& plan, const Observer& observer) {
  RigidModel<S>& model = run.model;
  restart(run, plan);
  run.observer = &observer;
  const S scale = state_scale(run.y.data(), model.state_size());
  const std::int64_t stride = plan.steps / plan.samples;
  Sample sample;
  const auto see = [&](std::int64_t k, S t_s) {
    if (!observer.sample) return;
    write_contacts(run, t_s, sample);
    observe(model, plan, k, run.y.data(), sample, observer);
  };
  model.select_interval(S(0), time_at<S>(plan, 1));
  see(0, S(0));
  std::int64_t step_end = 0;
  for (std::int64_t n = 0; n < plan.steps; ++n) {
    const S from_s = time_at<S>(plan, n), to_s = time_at<S>(plan, n + 1);
    model.select_interval(from_s, to_s);
    const auto begin = observer.profile ? std::chrono::steady_clock::now() : std::chrono::steady_clock::time_point{};
    const bool stepped = step_with_events(run, from_s, to_s - from_s);
    if (observer.profile)
      observer.profile->step_ns.push_back(
          std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - begin).count());
    if (!stepped) {
      if (run.outcome.status == Status::ok)
        run.outcome = {Status::diverged, "an implicit step has no solution", 0, 0, {}};
      break;
    }
    step_end = n + 1;
    if ((n + 1) % stride != 0) continue;
    if (!healthy(run.y.data(), model.state_size(), scale, to_s, run.outcome)) break;
    see((n + 1) / stride, to_s);
  }
  run.outcome.steps_taken = step_end;
  run.outcome.rate_evaluations = model.system().evaluations;
  return run.outcome;
}

template <class S>
Outcome run_in(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const Result<EventOptions> options = read_options(id, scene);
  if (!options) return unsupported(options.fault().reason);
  Simulation<S> simulation = prepare<S>(integrator_part(id), scene);
  if (simulation.outcome.status != Status::ok) return simulation.outcome;
  EventRun<S> run(*simulation.model, *simulation.stepper);
  run.options = *options;
  if (!id.rtol) run.free_flight = simulation.free_flight.get();
  prepare_run(run, id, scene);
  if (repeats <= 0) return run_once(run, plan, observer);

  const Observer nobody;
  Outcome outcome = run_once(run, plan, nobody);  // warm-up
  for (int i = 0; i < repeats && outcome.status == Status::ok; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const Outcome timed = run_once(run, plan, nobody);
    const auto busy = std::chrono::steady_clock::now() - start;
    outcome.busy_ns.push_back(std::chrono::duration_cast<std::chrono::nanoseconds>(busy).count());
    if (timed.status != Status::ok) outcome = timed;
  }
  return outcome;
}

}  // namespace
}  // namespace event

Outcome run_event(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (id.scalar == "float") return event::run_in<float>(id, scene, plan, observer, repeats);
  if (id.scalar.empty() || id.scalar == "double") return event::run_in<double>(id, scene, plan, observer, repeats);
  if (id.scalar == "long-double") return event::run_in<long double>(id, scene, plan, observer, repeats);
  return event::unsupported("atwood's contacts run in float, double and long-double, not in " + id.scalar);
}

}  // namespace atwood
