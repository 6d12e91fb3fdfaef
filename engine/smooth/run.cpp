#include "smooth/run.hpp"

#include <cmath>
#include <cstdio>
#include <type_traits>

#include "joints/constraints.hpp"
#include "protocol/refusal.hpp"
#include "protocol/timed_passes.hpp"
#include "smooth/stops.hpp"

namespace atwood {
namespace {

template <class S> std::string at_time(S t_s) { return " at t = " + format_double(static_cast<double>(t_s)) + " s"; }

template <class S> struct Run {
  Simulation<S>& simulation;
  const Plan& plan;
  const Observer* observer;  // null: the timed pass
  Sample sample;
  S scale{};
  StepLimits limits{};
  Stops<S> stops{simulation};
  std::vector<S> middle_y = {};  // of a step in two parts

  bool observe_state(std::int64_t k, const S* y) {
    Outcome& outcome = simulation.outcome;
    const S t_s = S(static_cast<double>(plan.t_end_s)) * S(k) / S(plan.samples);
    if (!healthy(y, simulation.model->state_size(), scale, t_s, outcome)) return false;
    if (observer != nullptr) observe(*simulation.model, plan, k, y, sample, *observer, simulation.stateful_force);
    return true;
  }
};

template <class S> void restart(Run<S>& run) {
  Simulation<S>& s = run.simulation;
  s.outcome = {};
  s.model->system().evaluations = 0;
  s.model->system().solvers = {};
  ++s.model->system().epoch;
  s.model->initial_state(s.y.data());
  if (s.model->constraints() != nullptr) {
    s.model->constraints()->restart();
    s.model->follow_turns(S(0), s.y.data());
  }
  if (s.stateful_force != nullptr) s.stateful_force->reset(s.model->motion(S(0), s.y.data()));
  run.scale = state_scale(s.y.data(), s.model->state_size());
}

template <class S> bool end_at(Simulation<S>& s, const std::string& fault, S t_s) {
  s.outcome.status = Status::diverged;
  s.outcome.reason = fault + at_time(t_s);
  return false;
}
// The sample at t = 0, which is the state before impacts at that instant. False: the run cannot begin.
template <class S> bool begin(Run<S>& run) {
  Simulation<S>& s = run.simulation;
  const bool stops = run.stops.any();
  if (stops && !run.stops.start(run.observer)) return end_at(s, run.stops.fault(), S(0));
  if (!run.observe_state(0, s.y.data())) return false;
  return !stops || run.stops.resolve_start() || end_at(s, run.stops.fault(), S(0));
}

// After an accepted step to t_s, whose end is y.
template <class S> void update_stateful_force(Simulation<S>& s, S t_s) {
  if (s.stateful_force != nullptr && s.stateful_force->accept_step(s.model->motion(t_s, s.y.data())))
    ++s.model->system().epoch;
}

template <class S> bool refuse_step(Simulation<S>& s, S t_s) {
  s.outcome.status = Status::diverged;
  s.outcome.reason = unsolved_step(s.model->system().solvers, static_cast<double>(t_s));
  return false;
}

// After an accepted step to t_s, whose end is y. False: the motion cannot go on.
template <class S> bool meets_constraints(Run<S>& run, S t_s) {
  Simulation<S>& s = run.simulation;
  if (s.model->constraints() == nullptr) return true;
  const std::string fault = s.model->constraint_fault(t_s, s.y.data());
  if (!fault.empty()) return end_at(s, fault, t_s);
  // Forces may depend on the angles of closing joints.
  const bool samples = run.observer != nullptr && run.observer->sample;
  if (samples || s.model->feels_forces()) s.model->follow_turns(t_s, s.y.data());
  return true;
}

// ---- the steps of the plan ----------------------------------------------------------------------------------------
// The step from (t_s, y) to y_new. Stages lie off the constraints by their own error; beside a singular configuration,
// at a distance d of it, their accelerations are in error by that over d. A step whose stages come nearer than a
// twentieth of the usual distance is taken in two parts, so divided that they do not, or as little as can be.
template <class S> bool trial_step(Run<S>& run, S t_s, S h_s) {
  Simulation<S>& s = run.simulation;
  const auto step = [&](S from_s, S by_s, const std::vector<S>& from, std::vector<S>& to) {
    return s.stepper->step(from_s, by_s, from.data(), to.data());
  };
  Constraints<S>* constraints = s.model->constraints();
  if (constraints != nullptr) constraints->reset_pivots();
  if (!step(t_s, h_s, s.y, s.y_new)) return false;
  if (constraints == nullptr || !(constraints->least_pivot() < constraints->typical_pivot() / S(20))) return true;
  run.middle_y.resize(s.y.size());
  // False: a step was not solved, or its stages come no farther from the singular configuration than `distance`.
  const auto in_two = [&](S part, S distance) {
    constraints->reset_pivots();
    return step(t_s, part * h_s, s.y, run.middle_y) && constraints->least_pivot() > distance &&
           step(t_s + part * h_s, h_s - part * h_s, run.middle_y, s.y_new) && constraints->least_pivot() > distance;
  };
  S farthest = constraints->least_pivot(), best = S(1);
  for (const double part : {0.5, 0.382, 0.618, 0.3, 0.7, 0.45, 0.55}) {
    if (!in_two(S(part), farthest)) continue;
    if (!(constraints->least_pivot() < constraints->typical_pivot() / S(20))) return true;
    farthest = constraints->least_pivot();
    best = S(part);
  }
  return best < S(1) ? in_two(best, S(0)) : step(t_s, h_s, s.y, s.y_new);
}

// The step up to the first event of a stop in it, which is resolved: `taken` becomes the fraction of h_s up to there.
template <class S> bool step_to_event(Run<S>& run, S t_s, S h_s, S& taken) {
  Simulation<S>& s = run.simulation;
  taken = S(1);
  if (!trial_step(run, t_s, h_s)) return refuse_step(s, t_s);
  if (run.stops.any() && !run.stops.locate(t_s, h_s, taken)) return refuse_step(s, t_s);
  s.y.swap(s.y_new);
  return true;
}

template <class S> bool one_step(Run<S>& run, const Plan& plan, std::int64_t n, S h_s) {
  Simulation<S>& s = run.simulation;
  S t_s = time_at<S>(plan, n), left_s = h_s;
  s.model->select_interval(t_s, t_s + h_s);
  if (!run.stops.any()) {
    S taken;
    if (!step_to_event(run, t_s, h_s, taken)) return false;
    update_stateful_force(s, t_s + h_s);
    return meets_constraints(run, t_s + h_s);
  }
  const S round_off_s = S(4) * real::epsilon<S>() * real::abs(t_s + h_s);
  while (left_s > round_off_s) {
    S taken;
    if (!step_to_event(run, t_s, left_s, taken)) return false;
    t_s += taken * left_s;
    if (taken < S(1) || run.stops.at_event()) {
      if (!run.stops.resolve(t_s)) return end_at(s, run.stops.fault(), t_s);
    }
    left_s = taken < S(1) ? left_s - taken * left_s : S(0);
    update_stateful_force(s, t_s);
    if (!meets_constraints(run, t_s)) return false;
  }
  return true;
}

// Steps [from, to) of bodies in free flight, in batches under one force law.
template <class S>
void march_free_flight(Simulation<S>& s, const Plan& plan, std::int64_t from, std::int64_t to, S h_s) {
  const auto begin_s = [&](std::int64_t n) { return time_at<S>(plan, n); };
  while (from < to) {
    s.model->select_interval(begin_s(from), begin_s(from) + h_s);
    std::int64_t until = s.model->switch_times_s().empty() ? to : from + 1;
    while (until < to && s.model->interval_selected(begin_s(until), begin_s(until) + h_s)) ++until;
    if constexpr (has_vector_lanes<S>) s.free_flight->march(h_s, until - from, s.y.data());
    s.outcome.steps_taken += until - from;
    from = until;
  }
}

template <class S> void march_equal_steps(Run<S>& run) {
  Simulation<S>& s = run.simulation;
  const Plan& plan = run.plan;
  const S h_s = time_at<S>(plan, 1);
  const std::int64_t stride = plan.steps / plan.samples;
  const bool equal = plan.frame_ends_s.empty();
  restart(run);
  if (!begin(run)) return;
  for (std::int64_t k = 0; k < plan.samples; ++k) {
    if (s.free_flight != nullptr && equal) march_free_flight(s, plan, k * stride, (k + 1) * stride, h_s);
    else
      for (std::int64_t n = k * stride; n < (k + 1) * stride; ++n) {
        if (!one_step(run, plan, n, equal ? h_s : time_at<S>(plan, n + 1) - time_at<S>(plan, n))) return;
        ++s.outcome.steps_taken;
      }
    if (!run.observe_state(k + 1, s.y.data())) return;
  }
}

// ---- adaptive steps ---------------------------------------------------------------------------------------------
template <class S> struct Tolerance { S rtol, atol; };

// The samples inside a step. What they evaluate is no work of the method: it would depend on their number.
template <class S> bool sample_inside(Run<S>& run, std::int64_t& k, S t_s, S h_s, S end_s, std::vector<S>& inside_y) {
  Simulation<S>& s = run.simulation;
  const std::int64_t evaluations = s.model->system().evaluations;
  for (; k < run.plan.samples; ++k) {
    const S sample_s = S(run.plan.t_end_s) * S(k) / S(run.plan.samples);
    if (sample_s > end_s) return true;
    if (s.stepper->dense_is_accurate()) s.stepper->dense((sample_s - t_s) / h_s, inside_y.data());
    else if (!s.stepper->step(t_s, sample_s - t_s, s.y.data(), inside_y.data())) return refuse_step(s, t_s);
    s.model->system().evaluations = evaluations;
    if (!run.observe_state(k, inside_y.data())) return false;
  }
  return true;
}

template <class S>
typename Stepper<S>::Advice judge_step(Simulation<S>& s, const Tolerance<S>& tolerance, StepControl<S>& control,
                                       S h_s) {
  if (s.stepper->chooses_steps()) return s.stepper->advise(tolerance.rtol, tolerance.atol);
  const S next_s = control.next_step(h_s, s.stepper->error_norm(tolerance.rtol, tolerance.atol));
  return {control.accepted(), next_s};
}

// The step from (t_s, y), at most step_s, in which a stateful force does not pass over a contact.
template <class S> S step_without_passing_over(Simulation<S>& s, S t_s, S step_s, std::vector<S>& rates) {
  rates.resize(s.y.size());
  s.model->system().rate(t_s, s.y.data(), rates.data());
  std::vector<Vec3<S>> acceleration_W(s.model->body_count());
  for (int body = 0; body < s.model->body_count(); ++body)
    if (const int at = s.model->offset(body); at >= 0)
      acceleration_W[body] = {rates[at + 3], rates[at + 4], rates[at + 5]};
  return s.stateful_force->longest_step(s.model->motion(t_s, s.y.data()), acceleration_W, step_s);
}

// Integrates from begin_s to end_s under one force law; h_s: the proposed step, updated for the next interval.
template <class S>
bool march_segment(Run<S>& run, const Tolerance<S>& tolerance, S begin_s, S end_s, S& h_s, std::int64_t& k,
                   std::vector<S>& inside_y) {
  Simulation<S>& s = run.simulation;
  StepControl<S> control(s.stepper->estimate_order(), run.limits);
  S t_s = begin_s;
  bool unsolved = false;
  while (t_s < end_s) {
    if (s.stateful_force != nullptr) {
      const S most_s = real::min(h_s, end_s - t_s), safe_s = step_without_passing_over(s, t_s, most_s, run.middle_y);
      if (safe_s < most_s) h_s = safe_s;
    }
    const bool last = t_s + h_s * S(1.0000001) >= end_s;
    const S step_s = last ? end_s - t_s : h_s;
    if (!(step_s > S(4) * real::epsilon<S>() * t_s)) {
      if (unsolved) return refuse_step(s, t_s);
      if (healthy(s.y_new.data(), s.model->state_size(), run.scale, t_s, s.outcome)) {
        s.outcome.status = Status::diverged;
        s.outcome.reason = "the step size fell below round-off" + at_time(t_s);
      }
      return false;
    }
    if (!s.stepper->step(t_s, step_s, s.y.data(),
                         s.y_new.data())) {  // implicit equations not solved: a shorter step's may be
      h_s = step_s / S(4);
      unsolved = true;
      continue;
    }
    unsolved = false;
    s.model->system().solvers.refused = {};
    const auto [accepted, next_s] = judge_step(s, tolerance, control, step_s);
    if (!accepted) {
      h_s = next_s;
      continue;
    }
    if (s.stateful_force != nullptr) {
      const S until_s = s.stateful_force->missed_contact(s.model->motion(t_s + step_s, s.y_new.data()), step_s);
      if (until_s < step_s) {
        h_s = until_s;
        continue;
      }
    }
    h_s = last ? real::max(h_s, next_s) : next_s;  // a step cut at end_s does not reduce the proposal
    S taken = S(1);
    if (run.stops.any() && !run.stops.locate(t_s, step_s, taken)) return refuse_step(s, t_s);
    const S reached_s = last && taken == S(1) ? end_s : t_s + taken * step_s;
    if (run.observer != nullptr && taken > S(0) && !sample_inside(run, k, t_s, taken * step_s, reached_s, inside_y))
      return false;
    s.y.swap(s.y_new);
    t_s = reached_s;
    if (run.stops.any() && run.stops.at_event() && !run.stops.resolve(t_s)) return end_at(s, run.stops.fault(), t_s);
    update_stateful_force(s, t_s);
    ++s.outcome.steps_taken;
    if (!meets_constraints(run, t_s)) return false;
  }
  return true;
}

template <class S> void march_adaptively(Run<S>& run, const Tolerance<S>& tolerance, std::vector<S>& inside_y) {
  Simulation<S>& s = run.simulation;
  const S end_s = S(run.plan.t_end_s);
  restart(run);
  s.stepper->set_tolerance(tolerance.rtol, tolerance.atol);
  if (!begin(run)) return;
  std::int64_t k = 1;
  S begin_s = S(0), h_s = time_at<S>(run.plan, 1);
  const std::vector<double>& switches = s.model->switch_times_s();
  for (std::size_t segment = 0; segment <= switches.size() && begin_s < end_s; ++segment) {
    const S until_s = segment < switches.size() ? real::min(S(switches[segment]), end_s) : end_s;
    if (!(begin_s < until_s)) continue;
    s.model->select_interval(begin_s, until_s);
    if (!march_segment(run, tolerance, begin_s, until_s, h_s, k, inside_y)) return;
    begin_s = until_s;
  }
  run.observe_state(run.plan.samples, s.y.data());
}

}  // namespace

std::optional<Fault> plan_fault(const MethodId& id, const Plan& plan) {
  if (!(plan.t_end_s > 0) || plan.steps < 1 || plan.samples < 1)
    return Fault{"a run needs t_end_s, steps and samples above 0"};
  if (!id.rtol && plan.steps % plan.samples != 0) return Fault{"samples must divide the number of equal steps"};
  if (id.rtol && !(*id.rtol > 0)) return Fault{"a tolerance must be above 0"};
  return {};
}

template <class S> std::optional<Fault> tolerance_fault(const MethodId& id, const Stepper<S>& stepper) {
  const double rtol = id.rtol.value_or(0), atol = id.atol.value_or(rtol / 100);
  const double round_off = static_cast<double>(real::epsilon<S>());
  if (stepper.takes_any_tolerance() || rtol + atol >= round_off / 4) return {};
  return Fault{"the tolerance " + format_double(rtol) + " is below the round-off of the state's scalar, " +
               format_double(round_off) + ": no error estimate can meet it"};
}

std::string unsolved_step(const SolverTallies& solvers, double t_s) {
  std::string words = "the implicit equations of the step at t = " + format_double(t_s) + " s were not solved";
  const SolveReport& last = solvers.refused;
  if (last.iterations == 0) return words;
  char residual[32];
  std::snprintf(residual, sizeof residual, "%.3g", last.residual);
  const char* const solver = solver_infos()[static_cast<std::size_t>(solvers.refused_of)].name;
  return words + ": residual " + residual + " after " + std::to_string(last.iterations) + " iterations (`" + solver +
         "`)";
}

StepLimits step_limits(const MethodId& id) {
  const Result<Settings> settings = merged_settings(*find_integrator(id.scheme), id.overrides);
  const StepLimits standard;
  if (!settings) return standard;  // refused before
  const auto of = [&](const char* name, double otherwise) {
    const auto found = settings->find(name);
    return found == settings->end() ? otherwise : std::get<double>(found->second);
  };
  return {of("safety", standard.safety), of("beta", standard.beta), of("least_factor", standard.least),
          of("most_factor", standard.most)};
}

template <class S>
Outcome run_smooth(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  Simulation<S> simulation = prepare<S>(id, scene);
  return run_prepared(simulation, id, plan, observer, repeats);
}

template <class S>
Outcome run_prepared(Simulation<S>& simulation, const MethodId& id, const Plan& plan, const Observer& observer,
                     int repeats) {
  if (const auto fault = plan_fault(id, plan)) return refused(*fault);
  if (simulation.outcome.status != Status::ok) return simulation.outcome;
  std::vector<S> inside_y(simulation.y.size());
  Run<S> run{simulation, plan, repeats > 0 ? nullptr : &observer, {}, {}, {}};
  const double rtol = id.rtol.value_or(0);
  if (id.rtol) run.limits = step_limits(id);
  const Tolerance<S> tolerance{S(rtol), S(id.atol.value_or(rtol / 100))};
  if (id.rtol)
    if (const auto fault = tolerance_fault(id, *simulation.stepper)) return refused(*fault);
  Outcome outcome = timed_passes(repeats, whole_pass([&] {
                                   if (id.rtol) march_adaptively(run, tolerance, inside_y);
                                   else march_equal_steps(run);
                                   return simulation.outcome;
                                 }));
  outcome.rate_evaluations = simulation.model->system().evaluations;
  simulation.model->system().solvers.keep_capped();
  outcome.solvers = named_tallies(simulation.model->system().solvers);
  return outcome;
}

template std::optional<Fault> tolerance_fault<float>(const MethodId&, const Stepper<float>&);
template std::optional<Fault> tolerance_fault<double>(const MethodId&, const Stepper<double>&);
template std::optional<Fault> tolerance_fault<long double>(const MethodId&, const Stepper<long double>&);
template std::optional<Fault> tolerance_fault<Quad>(const MethodId&, const Stepper<Quad>&);

template Outcome run_smooth<float>(const MethodId&, const Scene&, const Plan&, const Observer&, int);
template Outcome run_smooth<double>(const MethodId&, const Scene&, const Plan&, const Observer&, int);
template Outcome run_smooth<long double>(const MethodId&, const Scene&, const Plan&, const Observer&, int);
template Outcome run_smooth<Quad>(const MethodId&, const Scene&, const Plan&, const Observer&, int);

template Outcome run_prepared<float>(Simulation<float>&, const MethodId&, const Plan&, const Observer&, int);
template Outcome run_prepared<double>(Simulation<double>&, const MethodId&, const Plan&, const Observer&, int);
template Outcome run_prepared<long double>(Simulation<long double>&, const MethodId&, const Plan&, const Observer&,
                                           int);
template Outcome run_prepared<Quad>(Simulation<Quad>&, const MethodId&, const Plan&, const Observer&, int);

}  // namespace atwood
