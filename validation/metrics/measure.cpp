// The rows of one cell, from its recording.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <mutex>
#include <optional>

#include "validation/metrics/instants.hpp"
#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"
#include "validation/metrics/order_statistics.hpp"

namespace atwood {
namespace {

// perturbation_growth depends on the scenario only, and takes longer than the other figures of a cell, so it is cached.
// The key is all that it depends on: the scenario's id, ladder and true end state.
PerturbationGrowth remembered_growth(const Scenario& scenario, const Truth& truth) {
  static std::mutex mutex;
  static std::map<std::string, PerturbationGrowth> known;
  std::string key = scenario.id + " " + format_double(scenario.t_end_s);
  for (std::int64_t steps : scenario.steps) key += " " + std::to_string(steps);
  for (const BodySample& b : truth.values.back().bodies)
    for (const auto& v : {b.p_m, b.v_m_per_s})
      for (const Wide& x : v) key += " " + format_double(static_cast<double>(x));
  {
    const std::lock_guard lock(mutex);
    if (const auto found = known.find(key); found != known.end()) return found->second;
  }
  const PerturbationGrowth growth = perturbation_growth(scenario, truth);
  const std::lock_guard lock(mutex);
  return known[key] = growth;
}

// State errors; for a chaotic motion only up to its horizon, beyond which two true motions differ as much.
void append_foretold(const Scenario& scenario, const Truth& truth, const Observed& all, std::vector<Row>& rows) {
  const double horizon = metrics::state_horizon_s(scenario, truth);
  if (!(horizon < scenario.t_end_s)) {
    metrics::append_state_errors(scenario, all, rows);
    return;
  }
  Recording run = all.run;
  Truth until = all.truth;
  std::vector<bool> judged = all.judged;
  std::size_t kept = 0;
  while (kept < run.values.size() && static_cast<double>(run.values[kept].t_s) <= horizon) ++kept;
  run.values.truncate(kept);
  until.values.truncate(std::min(kept, until.values.size()));
  until.bars.truncate(std::min(kept, until.bars.size()));
  judged.resize(kept);
  const Observed known = observed_of(std::move(run), std::move(until), std::move(judged));
  rows.push_back(
      metrics::row("horizon", horizon, 0, "state errors are judged up to here, what is conserved over the whole run"));
  const std::size_t first = rows.size();
  metrics::append_state_errors(scenario, known, rows);
  for (std::size_t i = first; i < rows.size(); ++i)
    rows[i].reason = "up to the horizon, t = " + format_measure(horizon, 0) + " s";
}

}  // namespace

std::vector<Row> measure(const Scenario& scenario, const Truth& of_instants, const Recording& run) {
  using namespace metrics;
  const auto own = static_cast<std::size_t>(std::max<std::int64_t>(0, scenario.samples));
  std::optional<Truth> fewer;
  const Truth& truth = run.values.size() == own + 1 ? at_samples(of_instants, own, fewer) : of_instants;
  std::vector<Row> rows = status_rows(scenario, truth, run);
  append_solver_figures(run, rows);
  if (std::any_of(rows.begin(), rows.end(), [](const Row& r) { return r.metric == "status"; })) return rows;
  const Observed instants = observed(of_instants, run);
  const bool truth_of_samples = has_truth(truth) && !has_truth(instants.truth);  // a table of values
  std::optional<Recording> alone;
  if (truth_of_samples) alone = Recording{run.values, run.events, run.outcome};
  const Observed all = truth_of_samples ? observed(truth, *alone) : instants;
  if (has_truth(truth)) {
    append_foretold(scenario, truth, all, rows);
    append_landing(scenario, truth, run, rows);
    append_sizes(scenario, truth, rows);
    const PerturbationGrowth growth = remembered_growth(scenario, truth);
    rows.push_back(row("condition", growth.value, 0,
                       growth.followed ? "" : "at least: the growth of perturbations was not measured"));
  }
  append_norm_drift(scenario, run, rows);
  append_conservation(scenario, truth, run, instants, rows);
  append_joints(scenario, truth, run, all, rows);
  append_contact(scenario, truth, run, rows);
  const double floor = relative_floor(scenario.scene, run);
  GrowthFloors floors{0, floor, energy_floor(scenario, run, energy_scale(scenario, truth))};
  double size_m = 0, condition = 1;
  for (const Row& r : rows) {
    if (r.metric == "error-position-max") floors.position_m = r.truth_bar;
    if (r.metric == "size-position") size_m = r.value;
    if (r.metric == "condition") condition = std::max(condition, r.value);
  }
  floors.position_m = std::max(floors.position_m, floor * size_m * condition);
  floors.attitude_rad *= condition;
  append_growth(judged_series(scenario, truth, all), floors, rows);
  if (run.outcome.rate_evaluations > 0)
    rows.push_back(row("rate-evaluations", static_cast<double>(run.outcome.rate_evaluations)));
  return rows;
}

namespace {

// Distance to the farther end of the median's interval; NaN for a single time, which has none.
double bar_of(const Estimate& time) { return std::max(time.high - time.value, time.value - time.low); }

}  // namespace

// The rows of an engine that runs as WebAssembly have names of their own, so that nothing ranks it by time among native
// engines.
std::vector<Row> timing_rows(const Outcome& outcome, std::int64_t steps) {
  if (outcome.busy_ns.empty() || steps <= 0) return {};
  std::vector<double> ns(outcome.busy_ns.begin(), outcome.busy_ns.end());
  const Estimate run = metrics::median_interval(ns);
  const double per_step = 1e-9 / static_cast<double>(steps);
  const std::string reason = ns.size() == 1 ? "1 repeat: no interval is known" : std::to_string(ns.size()) + " repeats";
  if (outcome.call_ns > 0)
    return {metrics::row("step-time-wasm", run.value * per_step, bar_of(run) * per_step, reason),
            metrics::row("run-time-wasm", 1e-9 * run.value, 1e-9 * bar_of(run), reason),
            metrics::row("call-time-wasm", 1e-9 * static_cast<double>(outcome.call_ns))};
  std::vector<Row> rows{metrics::row("step-time", run.value * per_step, bar_of(run) * per_step, reason)};
  if (ns.size() >= metrics::kMinForP95)
    rows.push_back(metrics::row("step-time-p95", metrics::nearest_rank(ns, 0.95) * per_step, 0, reason));
  rows.push_back(metrics::row("run-time", 1e-9 * run.value, 1e-9 * bar_of(run), reason));
  return rows;
}

std::string format_measure(double value, double bar, int digits) {
  char text[64];
  if (std::isfinite(value) && bar > 0 && std::fabs(value) < 3 * bar)
    std::snprintf(text, sizeof text, "<= %.*g", digits, std::fabs(value) + bar);
  else std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

}  // namespace atwood
