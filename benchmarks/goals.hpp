// The goals of the project as data (benchmarks/goals.toml): a task, the wanted error and the budget.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "benchmarks/figures.hpp"

namespace atwood {

struct Goal {
  std::string id, title;
  std::string scenario, metric;                             // the task, and the figure that is judged
  double error = std::numeric_limits<double>::quiet_NaN();  // in the metric's unit; NaN: no error is required
  std::string budget_kind;  // "seconds", "evaluations", "ns_per_step", "ns" (of a benchmark's figure), ""
  double budget = 0;
  std::int64_t samples = 1;         // of the accuracy pass, the end included; the timed pass observes nothing
  std::vector<std::int64_t> steps;  // of candidates without a tolerance
  std::vector<double> tolerances;   // "atwood/ias15:tol" is a candidate at each
  std::int64_t first_steps = 0;     // sets the first step of adaptive candidates
  std::vector<std::string> methods, rivals, uncounted;  // ids and globs; uncounted: compared, but cannot reach the goal
  std::string benchmark;                                // instead of a scenario: a figure of a benchmark, over `per`
  std::vector<std::string> rival_benchmarks;
  double per = 1;
  double times_faster = 0;  // the cheapest rival's time over ours; 0: not required
  double error_ratio = 0;   // instead of `error`: relative to the most accurate rival's error; 0: not required
  double limit_s = 0;       // of a run; 0: that of --limit. Long runs are timed once, not alternately
  // Of fluids. Several spacings: a ladder, for an order. 0, empty: the scenario's own.
  std::vector<double> spacings_m;
  double sound_speed_m_per_s = 0, t_end_s = 0;
  std::vector<std::int64_t> rival_steps;  // of rivals without a tolerance; empty: those of `steps`
  std::int64_t seeds = 1;                 // of disturbed particles: the error is the median over seeds 1, 2 ..
  std::int64_t rival_seeds = 0;           // of rivals, whose runs take minutes; 0: as many
  std::int64_t phases = 1;                // the error is the largest over this many phases (goal_variants.hpp)
  std::int64_t starts = 1;                // the error is the root mean square over this many starts (goal_variants.hpp)
  double at_s = 0;                        // the figure at this instant; 0: of the whole run
  double low = std::numeric_limits<double>::quiet_NaN(), high = low;  // instead of `error`: the figure lies between
  std::string table, row, column;  // instead of a scenario: a figure of `atwood bench TABLE`, at most `error`
};

std::vector<Goal> read_goals(const std::string& path);  // InputError
// "16.7 ms", "40us": seconds. Throws InputError that begins with `what`.
double parse_duration(const std::string& text, const std::string& what);

}  // namespace atwood
