#include "reports/command_line/spread.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "reports/command_line/advise.hpp"
#include "reports/render/text.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {
namespace {

struct Apart {
  double position_m = 0, velocity_m_per_s = 0, t_s = 0;
};

double distance(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  Wide sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(static_cast<double>(sum));
}

Apart apart(const Recording& a, const Recording& b) {
  Apart largest;
  for (std::size_t k = 0; k < std::min(a.values.size(), b.values.size()); ++k) {
    for (std::size_t i = 0; i < std::min(a.values[k].bodies.size(), b.values[k].bodies.size()); ++i) {
      const double position = distance(a.values[k].bodies[i].p_m, b.values[k].bodies[i].p_m);
      largest.velocity_m_per_s = std::max(largest.velocity_m_per_s,
                                          distance(a.values[k].bodies[i].v_m_per_s, b.values[k].bodies[i].v_m_per_s));
      if (!(position > largest.position_m)) continue;
      largest.position_m = position;
      largest.t_s = static_cast<double>(a.values[k].t_s);
    }
  }
  return largest;
}

}  // namespace

std::vector<NamedRun> run_engines(const Scenario& scenario, std::int64_t samples, const std::vector<Worker>& workers,
                                  double limit_s) {
  const std::int64_t finest = *std::max_element(scenario.steps.begin(), scenario.steps.end());
  const std::int64_t steps = (finest + samples - 1) / samples * samples;
  const bool contacts = classify(scenario.scene).contacts;
  std::vector<NamedRun> runs;
  for (const Worker& worker : workers) {
    if (worker.status != Status::ok || worker.engine.methods.empty()) continue;
    std::vector<std::string> methods{worker.engine.methods.front().id};
    if (worker.engine.name == "atwood")
      methods = contacts ? std::vector<std::string>{"atwood/rk4+event", "atwood/symplectic-euler+impulse"}
                         : std::vector<std::string>{"atwood/rk4"};
    for (const std::string& method : methods) {
      Recording run = run_once(worker, method, scenario.scene, {scenario.t_end_s, steps, samples}, limit_s);
      if (run.outcome.status == Status::ok)
        runs.push_back({fmt::format("{}, {} steps", method, steps), std::move(run)});
    }
  }
  return runs;
}

std::vector<NamedRun> run_finest(const std::vector<Cell>& cells, const std::string& scenario,
                                 const std::vector<Row>& rows, const std::vector<Worker>& workers, double limit_s) {
  std::map<std::string, const Cell*> finest;  // by family
  for (const Cell& cell : cells) {
    if (cell.scenario->id != scenario || cell.worker < 0 || cell.probe != Probe::none) continue;
    const bool ended_well = std::any_of(rows.begin(), rows.end(), [&](const Row& row) {
      return row.scenario == scenario && row.method == cell.method && row.steps == cell.plan.steps &&
             row.metric == "status" && row.status == Status::ok;
    });
    const bool failed = std::any_of(rows.begin(), rows.end(), [&](const Row& row) {
      return row.scenario == scenario && row.method == cell.method && row.steps == cell.plan.steps &&
             row.metric == "status" && row.status != Status::ok;
    });
    if (failed && !ended_well) continue;
    const Cell*& best = finest[method_family(cell.method)];
    const auto tolerance = [](const Cell& one) { return parse_method_id(one.method).rtol.value_or(0); };
    if (best == nullptr || cell.plan.steps > best->plan.steps ||
        (cell.plan.steps == best->plan.steps && tolerance(cell) < tolerance(*best)))
      best = &cell;
  }
  std::vector<NamedRun> runs;
  for (const auto& [family, cell] : finest) {
    Recording run = run_once(workers[static_cast<std::size_t>(cell->worker)], cell->method, cell->scenario->scene,
                             own_plan(*cell), limit_s);
    if (run.outcome.status == Status::ok)
      runs.push_back({fmt::format("{}, {}", family, rung_words(cell->method, cell->plan.steps)), std::move(run)});
  }
  return runs;
}

std::vector<std::string> spread_lines(const std::vector<NamedRun>& runs, bool with_first) {
  std::vector<std::string> lines{"no truth: differences between the engines' finest runs, which are not errors"};
  for (std::size_t i = 0; i < (with_first ? std::min<std::size_t>(1, runs.size()) : runs.size()); ++i) {
    for (std::size_t j = i + 1; j < runs.size(); ++j) {
      if (runs[i].run.values.size() != runs[j].run.values.size()) continue;
      const Apart far = apart(runs[i].run, runs[j].run);
      lines.push_back(fmt::format("{:.3g} m apart at most (t = {:.6g} s), {:.3g} m/s: {} and {}", far.position_m,
                                  far.t_s, far.velocity_m_per_s, runs[i].name, runs[j].name));
    }
  }
  if (lines.size() == 1) lines.push_back("fewer than two runs completed: there is nothing to compare");
  return lines;
}

}  // namespace atwood
