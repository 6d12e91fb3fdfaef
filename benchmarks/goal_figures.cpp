// Goals for a figure of a benchmark or of a table.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "benchmarks/goal_run.hpp"
#include "validation/gates/gates.hpp"

namespace atwood {
GoalResult blank_result(const Goal& goal) {
  GoalResult result;
  result.id = goal.id;
  result.title = goal.title;
  result.scenario = goal.scenario;
  result.metric = goal.metric;
  result.wanted_error = goal.error;
  result.low = goal.low, result.high = goal.high;
  result.budget_kind = goal.budget_kind;
  result.budget = goal.budget;
  result.ratio = result.ratio_low = result.ratio_high = kNotMeasured;
  result.wanted_ratio = goal.times_faster;
  return result;
}

GoalResult judge_figure(const Goal& goal, const std::vector<BenchFigure>& figures) {
  GoalResult result;
  result.id = goal.id;
  result.title = goal.title;
  result.wanted_error = result.ratio = result.ratio_low = result.ratio_high = kNotMeasured;
  result.budget_kind = "ns";
  result.budget = goal.budget;
  const auto entrant = [&](const std::vector<std::string>& names) {
    GoalEntrant best{"", 0, kNotMeasured, 0, kNotMeasured, kNotMeasured, kNotMeasured, true};
    for (const BenchFigure& figure : figures) {
      if (std::none_of(names.begin(), names.end(),
                       [&](const std::string& name) { return glob_match(name, figure.name); }))
        continue;
      const double ns = figure.ns_per_step.value / goal.per;
      if (best.method.empty() || ns < best.ns_per_step) best.method = figure.name, best.ns_per_step = ns;
    }
    return best;
  };
  result.ours = entrant({goal.benchmark});
  result.rival = entrant(goal.rival_benchmarks);
  if (result.ours.method.empty()) result.why = "no benchmark of that name was run";
  else if (result.ours.ns_per_step > goal.budget)
    result.why = fmt::format("{:.3g} times over the budget", result.ours.ns_per_step / goal.budget);
  result.reached = result.why.empty();
  if (!result.ours.method.empty() && !result.rival.method.empty())
    result.ratio = result.rival.ns_per_step / result.ours.ns_per_step;
  return result;
}

GoalResult judge_table(const Goal& goal, const std::vector<BenchTable>& tables) {
  GoalResult result = blank_result(goal);
  result.metric = goal.column;
  const auto table =
      std::find_if(tables.begin(), tables.end(), [&](const BenchTable& t) { return t.id == goal.table; });
  if (table == tables.end()) {
    result.why = fmt::format("there is no table `{}`", goal.table);
    return result;
  }
  const auto column = std::find(table->columns.begin(), table->columns.end(), goal.column) - table->columns.begin();
  for (const auto& row : table->rows) {
    if (!std::holds_alternative<std::string>(row.at(0)) || std::get<std::string>(row[0]) != goal.row ||
        column >= std::ssize(row))
      continue;
    if (const auto* value = std::get_if<double>(&row[static_cast<std::size_t>(column)]);
        value != nullptr && std::isfinite(*value)) {
      result.ours = {goal.row, 0, *value, 0, kNotMeasured, kNotMeasured, kNotMeasured, *value <= goal.error};
    }
  }
  result.why = result.ours.method.empty() ? fmt::format("no figure in `{}`, `{}`", goal.row, goal.column)
               : result.ours.accurate     ? ""
                                          : "it is above that";
  result.reached = result.why.empty();
  return result;
}

std::string benchmark_filter(const Goal& goal) {
  std::string filter;
  const auto add = [&](const std::string& glob) {
    std::string pattern;
    for (const char c : glob) {
      if (c == '*') pattern += ".*";
      else if (std::string(".+()[]{}^$|\\?").find(c) != std::string::npos) pattern += std::string("\\") + c;
      else pattern += c;
    }
    filter += (filter.empty() ? "^" : "|^") + pattern;
  };
  if (goal.benchmark.empty()) return filter;
  add(goal.benchmark);
  for (const std::string& name : goal.rival_benchmarks) add(name);
  return filter;
}

}  // namespace atwood
