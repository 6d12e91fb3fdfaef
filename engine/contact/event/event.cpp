#include "contact/event/event.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "contact/event/contact_forces.hpp"
#include "contact/event/edge_candidates.hpp"
#include "contact/event/step.hpp"
#include "contact/options.hpp"
#include "protocol/refusal.hpp"
#include "protocol/timed_passes.hpp"
#include "smooth/run.hpp"

namespace atwood {

namespace event {
namespace {

// The scene's convention for simultaneous impacts, if it names one, overrides the setting's default.
Result<EventOptions> with_convention(const MethodId& id, const Scene& scene, EventOptions options) {
  if (scene.simultaneous_impacts == SimultaneousImpacts::unspecified) return options;
  const bool together = scene.simultaneous_impacts == SimultaneousImpacts::together;
  if (id.overrides.count("simultaneous") > 0 && together != options.simultaneous)
    return Fault{std::string("+event: simultaneous=") + (together ? "sequential" : "together") +
                 " contradicts the scene, whose simultaneous_impacts is `" + (together ? "together" : "sequential") +
                 "`"};
  options.simultaneous = together;
  return options;
}

Result<EventOptions> read_options(const MethodId& id, const Scene& scene) {
  EventOptions options;
  const Result<Settings> settings = response_settings(id);
  if (!settings) return settings.fault();
  const auto& restitution = std::get<std::string>(settings->at("restitution"));
  if (restitution == "poisson") options.restitution = Restitution::poisson;
  else if (restitution == "stronge") options.restitution = Restitution::stronge;
  options.simultaneous = std::get<std::string>(settings->at("simultaneous")) == "together";
  return with_convention(id, scene, options);
}

template <class S> void find_drag_bodies(EventRun<S>& run, const Scene& scene) {
  for (const Force& force : scene.forces) {
    const auto* drag = std::get_if<QuadraticDrag>(&force);
    if (!drag) continue;
    for (const int body : drag->bodies)
      if (run.bodies.model.offset(body) >= 0) run.drag_bodies.push_back({body, narrow3<S>(drag->wind_m_per_s)});
  }
}

// A method that splits forces or expands them in series never evaluates rates, which contact forces are added to. Takes
// a trial step to find out; overwrites states.y and y_new, and the counts of calls.
template <class S> bool evaluates_rates(EventRun<S>& run) {
  run.bodies.model.initial_state(run.states.overwrite(run.states.y));
  run.bodies.model.select_interval(S(0), S(0));
  run.integration.wrapped_calls = 0;
  run.bodies.model.system().evaluations = 0;
  run.integration.stepper.step(S(0), S(0x1p-20), run.states.y.data(), run.states.overwrite(run.states.y_new));
  return run.integration.wrapped_calls > 0 && run.integration.wrapped_calls == run.bodies.model.system().evaluations;
}

// A stepper of an explicit scheme, which takes every model.
template <class S> std::unique_ptr<Stepper<S>> required_stepper(RigidModel<S>& model, const std::string& scheme) {
  auto stepper = make_stepper<S>(scheme, model);
  if (!stepper) throw std::logic_error("+event needs atwood/" + scheme + ": " + stepper.fault().reason);
  return std::move(*stepper);
}

template <class S> void size_states(const Bodies<S>& bodies, StateBuffers<S>& states) {
  const auto size = static_cast<std::size_t>(bodies.model.state_size());
  for (State<S>* state : {&states.y, &states.y_new, &states.y_probe, &states.y_before_impacts})
    state->values.resize(size);
  states.dydt.resize(size);
  bodies.model.initial_state(states.overwrite(states.y));
}

// Poses of all bodies in the state y, of fixed ones for good, and which bodies are isotropic.
template <class S> void initialize_poses(Bodies<S>& bodies, const S* y) {
  const auto count = static_cast<std::size_t>(bodies.model.body_count());
  bodies.poses.resize(count);
  bodies.moves.resize(count);
  bodies.isotropic.resize(count);
  for (int i = 0; i < bodies.model.body_count(); ++i) {
    const BodyState<S> state = bodies.model.body(i, y);
    Pose<S>& pose = bodies.poses[i];
    pose.p = state.p_WB;
    const Vec3<S> axes[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};
    for (int k = 0; k < 3; ++k) pose.axis[k] = rotate(state.q_WB, axes[k]);
    const MassProperties<S>& mass = bodies.model.mass(i);
    bodies.isotropic[i] = bodies.model.offset(i) >= 0 && bodies.model.rotates(i) && mass.diagonal &&
                          mass.I_row[0].x == mass.I_row[1].y && mass.I_row[0].x == mass.I_row[2].z;
  }
}

// Sizes what is indexed by bodies, and reserves what grows to the number of pairs, bodies or candidates.
template <class S> void reserve_memory(EventRun<S>& run) {
  const auto bodies = static_cast<std::size_t>(run.bodies.model.body_count());
  for (auto* v : {&run.proximity.path_length, &run.proximity.path_bounds}) v->resize(bodies);
  for (auto* v : {&run.constraints.free_acceleration, &run.constraints.acceleration}) v->resize(bodies);
  run.constraints.loaded.resize(bodies);
  run.active.contacts_on_body.resize(bodies);
  run.active.bodies.reserve(bodies);
  run.proximity.near.reserve(run.proximity.pairs.size());
  const std::size_t candidates = run.proximity.candidates.size();
  run.impacts.points.reserve(candidates);
  run.impacts.applied.reserve(candidates);
  for (auto* v : {&run.active.contacts, &run.active.previous, &run.active.kept}) v->reserve(candidates);
  run.active.previous_states.reserve(candidates);
}

// Tolerances, and the steppers for contacts and for slip where the method's own will not do.
template <class S> void choose_steppers(EventRun<S>& run, const MethodId& id) {
  Integration<S>& integration = run.integration;
  if (id.rtol) {
    integration.rtol = S(*id.rtol);
    integration.atol = S(id.atol.value_or(*id.rtol / 100));
    integration.stepper.set_tolerance(integration.rtol, integration.atol);
  }
  if (!evaluates_rates(run))
    integration.contact_stepper = required_stepper(run.bodies.model, id.rtol ? "dopri5" : "rk4");
  if (std::any_of(run.proximity.pairs.begin(), run.proximity.pairs.end(),
                  [](const ShapePair<S>& pair) { return pair.friction > S(0); }))
    integration.fine_stepper = required_stepper(run.bodies.model, "dop853");
}

// Once a run.
template <class S> void prepare_run(EventRun<S>& run, const MethodId& id, const Scene& scene) {
  size_states(run.bodies, run.states);
  initialize_poses(run.bodies, run.states.y.data());
  build_candidates(run.bodies, run.proximity, scene);
  list_edges(run.proximity, scene);
  find_drag_bodies(run, scene);
  initialize_inverse_inertia(run.bodies);
  reserve_memory(run);
  install_contact_forces(run);
  choose_steppers(run, id);
}

// Back to the initial state: what earlier runs left is cleared, so that repeats give the same bits.
template <class S> void restart(EventRun<S>& run, const Plan& plan) {
  run.report.outcome = {};
  run.active.contacts.clear();
  run.active.count = 0;
  run.active.inconsistent = -1;
  run.active.last_painleve_s = S(-1);
  run.active.painleve_impacts = 0;
  run.active.is_first_step = true;
  run.integration.use_fine_stepper = false;
  run.active.active_set_epoch = -1;
  run.integration.h_next_s = S(0);
  run.bodies.speed_scale = norm(run.bodies.model.uniform_gravity()) * S(plan.t_end_s) / S(plan.steps);
  std::fill(run.proximity.path_length.begin(), run.proximity.path_length.end(), S(0));
  remove_edge_candidates(run.proximity);
  for (Candidate<S>& candidate : run.proximity.candidates) {
    candidate.in_contact = false;
    candidate.last_triangle = 0;  // results do not depend on earlier runs
  }
  for (ShapePair<S>& pair : run.proximity.pairs) {
    pair.travel_until_recheck = S(0);
    pair.gaps_segment = -1;
    pair.overlaps_at_start = false;
    pair.last_bounce = false;
    pair.bounces_end_s = S(0);
  }
  run.bodies.model.initial_state(run.states.overwrite(run.states.y));
  run.bodies.model.system().evaluations = 0;
  run.bodies.model.system().solvers = {};
  ++run.bodies.model.system().epoch;
}

std::array<double, 3> as_doubles(const auto& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

// Contact forces at this instant, by the law that held up to it.
template <class S> void write_contacts(EventRun<S>& run, S t_s, Sample& sample) {
  sample.contacts.clear();
  if (run.active.count == 0) return;
  evaluate_rates(run, t_s);
  for (const Contact<S>& contact : run.active.contacts) {
    if (!contact.active) continue;
    const Candidate<S>& candidate = run.proximity.candidates[contact.candidate];
    const ShapePair<S>& pair = run.proximity.pairs[candidate.pair];
    const S sign = candidate.feature_body == pair.b ? S(1) : S(-1);  // of the force on b
    sample.contacts.push_back({pair.a, pair.b, as_doubles(contact.kinematics.x),
                               as_doubles(sign * contact.kinematics.normal),
                               static_cast<double>(contact.kinematics.gap), static_cast<double>(contact.normal_N),
                               as_doubles(sign * contact.friction_N)});
  }
}

template <class S> Outcome run_once(EventRun<S>& run, const Plan& plan, const Observer& observer) {
  RigidModel<S>& model = run.bodies.model;
  restart(run, plan);
  run.report.observer = &observer;
  const S scale = state_scale(run.states.y.data(), model.state_size());
  const std::int64_t stride = plan.steps / plan.samples;
  Sample sample;
  const auto see = [&](std::int64_t k, S t_s) {
    if (!observer.sample) return;
    write_contacts(run, t_s, sample);
    observe(model, plan, k, run.states.y.data(), sample, observer);
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
      if (run.report.outcome.status == Status::ok) {
        run.report.outcome = {
            Status::diverged, unsolved_step(model.system().solvers, static_cast<double>(from_s)), 0, 0, {}};
        model.system().solvers.keep_capped();
      }
      break;
    }
    step_end = n + 1;
    if ((n + 1) % stride != 0) continue;
    if (!healthy(run.states.y.data(), model.state_size(), scale, to_s, run.report.outcome)) break;
    see((n + 1) / stride, to_s);
  }
  run.report.outcome.steps_taken = step_end;
  run.report.outcome.rate_evaluations = model.system().evaluations;
  run.report.outcome.solvers = named_tallies(model.system().solvers);
  return run.report.outcome;
}

template <class S>
Outcome run_in(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const Result<EventOptions> options = read_options(id, scene);
  if (!options) return refused(options.fault());
  Simulation<S> simulation = prepare<S>(integrator_part(id), scene);
  if (simulation.outcome.status != Status::ok) return simulation.outcome;
  EventRun<S> run(*simulation.model, *simulation.stepper);
  run.options = *options;
  if (!id.rtol) run.integration.free_flight = simulation.free_flight.get();
  prepare_run(run, id, scene);
  if (repeats <= 0) return run_once(run, plan, observer);

  const Observer no_observer;
  return timed_passes(repeats, whole_pass([&] { return run_once(run, plan, no_observer); }));
}

}  // namespace
}  // namespace event

Outcome run_event(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (id.scalar == "float") return event::run_in<float>(id, scene, plan, observer, repeats);
  if (id.scalar.empty() || id.scalar == "double") return event::run_in<double>(id, scene, plan, observer, repeats);
  if (id.scalar == "long-double") return event::run_in<long double>(id, scene, plan, observer, repeats);
  return refused("atwood's contacts run in float, double and long-double, not in " + id.scalar);
}

}  // namespace atwood
