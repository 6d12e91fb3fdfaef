#include "benchmarks/last_quarter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "benchmarks/goal_variants.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

bool is_error_at_end(const std::string& metric) { return metric.starts_with("error-") && metric.ends_with("-end"); }

// Of a method with a tolerance as many as of most others. Of equal steps the largest number that divides them; 0: none.
std::int64_t samples_of(const Cell& cell) {
  if (method_family(cell.method) != cell.method) return 60;
  for (std::int64_t samples = 64; samples >= 8; --samples)
    if (cell.plan.steps % samples == 0) return samples;
  return 0;
}

// The samples of the start and of instant k, as if the run ended there.
SampleSeries ends_at(const SampleSeries& all, std::size_t k) {
  SampleSeries two;
  two.push_back(all.front());
  two.push_back(all[k]);
  return two;
}

}  // namespace

double LastQuarter::error(const Cell& cell) {
  const std::int64_t samples = samples_of(cell);
  if (!is_error_at_end(goal_.metric) || variant_count(goal_) > 1 || goal_.limit_s > 0 || samples == 0) return kNone;
  if (!cell.scenario->scene.fluids.empty() || !cell.scenario->frame_ends_s.empty()) return kNone;
  if (!truths_.contains(samples))
    truths_[samples] = truth_once(study_.truth_worker, *cell.scenario, samples, study_.truth_limit_s);
  const Truth& truth = truths_.at(samples);
  Plan plan = cell.plan;
  plan.samples = samples;
  const Recording run = run_once(workers_[static_cast<std::size_t>(cell.worker)], cell.method, cell.scenario->scene,
                                 plan, study_.cell_limit_s);
  const std::size_t count = static_cast<std::size_t>(samples) + 1;
  if (truth.values.size() != count || truth.bars.size() != count) return kNone;
  if (run.outcome.status == Status::diverged || run.outcome.status == Status::not_finite) return kUnbounded;
  if (run.outcome.status != Status::ok || run.values.size() != count) return kNone;
  double most = kNone;
  Scenario until = *cell.scenario;
  until.samples = 1;
  for (std::size_t k = (3 * count + 3) / 4 - 1; k < count; ++k) {
    until.t_end_s = static_cast<double>(truth.values[k].t_s);
    Truth here;
    here.outcome = truth.outcome;
    here.source = truth.source;
    here.values = ends_at(truth.values, k);
    here.bars = ends_at(truth.bars, k);
    Recording there;
    there.outcome = run.outcome;
    there.values = ends_at(run.values, k);
    for (const Row& row : measure(until, here, there)) {
      const bool is_figure = row.metric == goal_.metric && row.body.empty() && !row.t_s;
      if (row.status == Status::not_finite || (is_figure && !std::isfinite(row.value))) return kUnbounded;
      if (is_figure && !(row.value <= most)) most = row.value;
    }
  }
  return most;
}

}  // namespace atwood
