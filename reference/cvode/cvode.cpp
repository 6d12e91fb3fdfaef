#include "cvode/cvode.hpp"

#include <sundials/sundials_config.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "cvode/walk.hpp"
#include "dynamics/arithmetic.hpp"

namespace atwood {

namespace {

using cvode::Formula;
using cvode::Tolerance;

constexpr double default_rtol = 1e-10;

Outcome unsupported(const std::string& reason) { return {Status::unsupported, reason, 0, 0, {}}; }

std::string fault_of(const MethodId& id) {
  if (id.engine != "cvode" || (id.scheme != "adams" && id.scheme != "bdf")) return "cvode offers adams and bdf, not " + id.scheme;
  if (!id.scalar.empty() && id.scalar != "double") return "cvode computes in double, not in " + id.scalar;
  if (!id.response.empty()) return "cvode locates impacts by itself; it takes no `+" + id.response + "`";
  if (!id.overrides.empty()) return "cvode has no setting `" + id.overrides.begin()->first + "` to change";
  return "";
}

Outcome run(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (const auto fault = fault_of(id); !fault.empty()) return unsupported(fault);
  if (const auto reason = cvode::refusal(scene); !reason.empty()) return unsupported(reason);
  const Formula formula = id.scheme == "adams" ? Formula::adams : Formula::bdf;
  const double rtol = id.rtol.value_or(default_rtol);
  const Tolerance tolerance{rtol, id.atol.value_or(rtol / 100)};
  if (repeats <= 0) return cvode::walk(scene, plan.t_end_s, plan.samples, formula, tolerance, observer);
  Outcome outcome = cvode::walk(scene, plan.t_end_s, 0, formula, tolerance, {});  // warm-up
  for (int i = 0; i < repeats && outcome.status == Status::ok; ++i) {
    const auto start = std::chrono::steady_clock::now();
    cvode::walk(scene, plan.t_end_s, 0, formula, tolerance, {});
    const auto busy = std::chrono::steady_clock::now() - start;
    outcome.busy_ns.push_back(std::chrono::duration_cast<std::chrono::nanoseconds>(busy).count());
  }
  return outcome;
}

MethodInfo method(const std::string& scheme, const std::string& doc, const std::string& nonlinear, std::int64_t max_order) {
  MethodInfo info;
  info.id = "cvode/" + scheme;
  info.doc = doc;
  info.source = "Hindmarsh et al., SUNDIALS, ACM Trans. Math. Softw. 31 (2005) 363; CVODE " SUNDIALS_VERSION;
  info.adaptive = true;
  info.settings = {{"rtol", default_rtol}, {"atol", std::string("rtol / 100")}, {"nonlinear_solver", nonlinear},
                   {"max_order", max_order}, {"max_steps", std::int64_t{2000000}},
                   {"impacts", std::string("root functions, restart")}, {"switches", std::string("stop time, restart")}};
  return info;
}

struct Solved {
  std::string name;
  Outcome outcome;
  std::vector<Sample> values;
  std::vector<Event> events;
};

Solved solve(const Scenario& scenario, std::int64_t samples, Formula formula, double rtol) {
  Solved solved;
  Observer observer;
  observer.sample = [&](const Sample& sample) { solved.values.push_back(sample); };
  observer.event = [&](const Event& event) { solved.events.push_back(event); };
  solved.outcome = cvode::walk(scenario.scene, scenario.t_end_s, samples, formula, {rtol, rtol / 100}, observer);
  return solved;
}

template <std::size_t n>
void widen(std::array<Wide, n>& bar, const std::array<Wide, n>& a, const std::array<Wide, n>& b) {
  for (std::size_t i = 0; i < n; ++i) bar[i] = std::max(bar[i], Wide(2) * dynamics::magnitude(Wide(a[i] - b[i])));
}

// Bars from the largest difference; a quaternion and its negative are the same attitude.
void widen_bars(std::vector<Sample>& bars, const std::vector<Sample>& values, const std::vector<Sample>& other) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    for (std::size_t i = 0; i < values[k].bodies.size(); ++i) {
      const BodySample& a = values[k].bodies[i];
      BodySample b = other[k].bodies[i];
      Wide same = 0;
      for (std::size_t c = 0; c < 4; ++c) same += a.q_wxyz[c] * b.q_wxyz[c];
      if (same < 0) for (auto& q : b.q_wxyz) q = -q;
      BodySample& bar = bars[k].bodies[i];
      widen(bar.p_m, a.p_m, b.p_m);
      widen(bar.q_wxyz, a.q_wxyz, b.q_wxyz);
      widen(bar.v_m_per_s, a.v_m_per_s, b.v_m_per_s);
      widen(bar.w_rad_per_s, a.w_rad_per_s, b.w_rad_per_s);
    }
  }
}

}  // namespace

Engine cvode_engine() {
  Engine engine;
  engine.name = "cvode";
  engine.version = SUNDIALS_VERSION;
  engine.scalar = "double";
  engine.methods = {
      method("adams", "Adams-Moulton of variable order and step with fixed-point iteration, started anew at impacts and switches.",
             "fixed point", 12),
      method("bdf", "Backward differentiation of variable order and step; Newton with a dense difference-quotient Jacobian.",
             "Newton, dense", 5)};
  engine.run = run;
  return engine;
}

Truth cvode_truth(const Scenario& scenario, std::int64_t samples) {
  Truth truth;
  truth.source = "CVODE " SUNDIALS_VERSION ": Adams and BDF at rtol 1e-10 and 1e-12; values of Adams 1e-12, bars twice the largest difference";
  if (const auto reason = cvode::refusal(scenario.scene); !reason.empty()) {
    truth.outcome = unsupported(reason);
    return truth;
  }
  Solved best = solve(scenario, samples, Formula::adams, 1e-12);
  truth.outcome = best.outcome;
  if (best.outcome.status != Status::ok) return truth;
  truth.values = best.values;
  truth.events = best.events;
  truth.event_bar_s.assign(best.events.size(), 0);
  for (const auto& value : truth.values) truth.bars.push_back({value.t_s, std::vector<BodySample>(value.bodies.size())});
  for (auto& bar : truth.bars) for (auto& body : bar.bodies) body.q_wxyz = {};
  for (const auto& [formula, rtol] : {std::pair{Formula::adams, 1e-10}, {Formula::bdf, 1e-10}, {Formula::bdf, 1e-12}}) {
    const Solved other = solve(scenario, samples, formula, rtol);
    if (other.outcome.status != Status::ok || other.events.size() != best.events.size()) {
      truth.outcome = {Status::diverged, "CVODE's Adams and BDF do not agree on the course of events: no bar can be given", 0, 0, {}};
      return truth;
    }
    widen_bars(truth.bars, truth.values, other.values);
    for (std::size_t k = 0; k < best.events.size(); ++k) {
      truth.event_bar_s[k] = std::max(truth.event_bar_s[k],
                                      2 * std::abs(static_cast<double>(best.events[k].t_s - other.events[k].t_s)));
    }
  }
  return truth;
}

}  // namespace atwood
