// The goals of the project as data (benchmarks/goals.toml): a task, the error that is wanted and the budget for it.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "benchmarks/figures.hpp"

namespace atwood {

struct Goal {
  std::string id, title;
  std::string scenario, metric;                             // the work, and the figure that is judged
  double error = std::numeric_limits<double>::quiet_NaN();  // in the metric's unit; NaN: none is asked
  std::string budget_kind;  // "seconds", "evaluations", "ns_per_step", "ns" (of a benchmark's figure), ""
  double budget = 0;
  std::int64_t samples = 1;         // of the accuracy pass, the end included; the timed pass observes nothing
  std::vector<std::int64_t> steps;  // of candidates without a tolerance
  std::vector<double> tolerances;   // "atwood/ias15:tol" is a candidate at each
  std::int64_t first_steps = 0;     // what adaptive candidates take their first step from
  std::vector<std::string> methods, rivals, uncounted;  // ids and globs; uncounted: compared, but reaches no goal
  std::string benchmark;                                // instead of a scenario: a figure of a benchmark, over `per`
  std::vector<std::string> rival_benchmarks;
  double per = 1;
  double times_faster = 0;         // 0: not asked. The cheapest rival's time over ours
  double error_ratio = 0;          // 0: not asked. Instead of `error`: of the most accurate rival's error
  double limit_s = 0;              // a run may take; 0: as --limit says. Long runs are timed once, not in turns
  std::string table, row, column;  // instead of a scenario: a figure of `atwood bench TABLE`, at most `error`
};

std::vector<Goal> read_goals(const std::string& path);  // InputError
// "16.7 ms", "40us": seconds. Throws InputError that begins with `what`.
double parse_duration(const std::string& text, const std::string& what);

}  // namespace atwood
