// One cell's recording in, its rows out.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "validation/metrics/measurements.hpp"

namespace atwood {

std::vector<Row> measure(const Scenario& scenario, const Truth& truth, const Recording& run) {
  using namespace metrics;
  std::vector<Row> rows = status_rows(scenario, truth, run);
  if (!rows.empty()) return rows;
  if (has_truth(truth)) {
    append_state_errors(scenario, truth, run, rows);
    append_landing(scenario, truth, run, rows);
    append_sizes(scenario, truth, rows);
    rows.push_back(row("condition", truth.condition > 0 ? truth.condition : perturbation_growth(scenario, truth)));
  }
  append_conservation(scenario, run, rows);
  append_contact(scenario, truth, run, rows);
  double truth_bar_m = 0, size_m = 0;
  for (const Row& r : rows) {
    if (r.metric == "error-position-max") truth_bar_m = r.truth_bar;
    if (r.metric == "size-position") size_m = r.value;
  }
  append_growth(error_series(scenario, truth, run), std::max(truth_bar_m, 0x1p-53 * size_m), rows);
  if (run.outcome.rate_evaluations > 0)
    rows.push_back(row("rate-evaluations", static_cast<double>(run.outcome.rate_evaluations)));
  return rows;
}

std::vector<Row> timing_rows(const Outcome& outcome, std::int64_t steps) {
  if (outcome.busy_ns.empty() || steps <= 0) return {};
  std::vector<std::int64_t> ns = outcome.busy_ns;
  std::sort(ns.begin(), ns.end());
  const std::size_t n = ns.size();
  const double median = n % 2 == 1 ? static_cast<double>(ns[n / 2])
                                   : (static_cast<double>(ns[n / 2 - 1]) + static_cast<double>(ns[n / 2])) / 2;
  // Nearest rank: the smallest value that at least 95 % of the repeats do not exceed.
  const std::size_t rank = (95 * n + 99) / 100;
  const double per_step = 1e-9 / static_cast<double>(steps);
  const std::string reason = std::to_string(n) + " repeats";
  return {metrics::row("step-time", median * per_step, 0, reason),
          metrics::row("step-time-p95", static_cast<double>(ns[rank - 1]) * per_step, 0, reason)};
}

std::string format_measure(double value, double bar) {
  char text[64];
  if (std::isfinite(value) && bar > 0 && std::fabs(value) < 3 * bar)
    std::snprintf(text, sizeof text, "<= %.2g", std::fabs(value) + bar);
  else
    std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace atwood
