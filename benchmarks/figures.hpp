// Figures of the benchmarks: times of steps and kernels, tables, goals.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "validation/metrics/order_statistics.hpp"

namespace atwood {

// A benchmark's time: of a step of a catalogue's scene, or of one call of a kernel.
struct BenchFigure {
  std::string scenario, method;  // empty: a kernel
  std::int64_t steps = 0;
  Estimate ns_per_step;        // the median over the repetitions and its interval by order statistics
  double ns_per_step_p95 = 0;  // NaN of fewer than 20 repetitions
  std::string name;
};

// A table of measured figures with its title: broad phases, or the largest heap per frame and engine.
using TableCell = std::variant<double, std::string>;  // NaN: no figure
struct BenchTable {
  std::string id, title;
  std::vector<std::string> columns;
  std::vector<std::vector<TableCell>> rows;  // one cell per column
  std::vector<std::string> notes;            // how to read it
};

// A goal of the project, measured beside its rivals in one run (benchmarks/goals.toml).
struct GoalEntrant {
  std::string method;  // empty: none
  std::int64_t steps = 0;
  double error = 0, bar = 0;            // NaN: the goal asks for no error
  double seconds = 0, evaluations = 0;  // of the run; NaN: not timed or not counted
  double ns_per_step = 0;
  bool accurate = false;  // reaches the wanted error
  // The largest error over the last quarter of the run, of a figure at its end; infinity: some state there is not
  // finite; NaN: not measured. Ours may not be more than kCancelled times the goal's error: it would reach the goal
  // where its error passes through zero.
  double last_quarter = std::numeric_limits<double>::quiet_NaN();
  double floor = std::numeric_limits<double>::quiet_NaN();  // accuracy_floor() of the error; NaN: not known
};
inline constexpr double kCancelled = 10;
inline constexpr double kMaxEvaluations = 10;  // of a rival, in those of its engine's cheapest rung
// What else ran on the machine while a goal was timed.
struct MachineState {
  std::int64_t timings = 0, interrupted = 0;  // interrupted: the worker had to wait for its processor
  std::int64_t repeated = 0;                  // timed again for this reason
  double ghz_low = std::numeric_limits<double>::quiet_NaN(), ghz_high = ghz_low;  // clock rate, over the rounds
  std::int64_t again = 0;  // how often the whole goal was timed again, since the machine was busy (calmest.hpp)
};
// The share of the timings that was interrupted in tenths, or the spread of the clock rate in tenths of the lowest; the
// larger. Above 1 the machine is called busy, and times may be too long.
inline double unrest(const MachineState& machine) {
  const double of_timings =
      machine.timings > 0 ? 10 * static_cast<double>(machine.interrupted) / static_cast<double>(machine.timings) : 0;
  const double of_clock = 10 * (machine.ghz_high / machine.ghz_low - 1);
  return of_clock > of_timings ? of_clock : of_timings;
}
inline bool busy(const MachineState& machine) { return unrest(machine) > 1; }
struct GoalResult {
  std::string id, title, scenario, metric, unit;
  double wanted_error = 0;  // NaN: none
  std::string budget_kind;  // "seconds", "evaluations", "ns_per_step", "ns" (a benchmark's figure), "" (none)
  double budget = 0;
  bool reached = false;
  GoalEntrant ours, rival, uncounted;  // the best of each
  double ratio = 0, ratio_low = 0,
         ratio_high = 0;    // rival's cost over ours [95 %], where both reach the error; else NaN
  std::string why;          // why the goal is missed; empty when reached
  double wanted_ratio = 0;  // the required ratio of the rival's cost to ours; 0: none
  // Comparison with a library (odeint, ARKODE, CVODE): its best method and our best one, both with the reference's
  // rate, and the ratio of their times. Empty methods, NaN ratios: no library is among the rivals, or one misses the
  // error.
  GoalEntrant same_rate = {}, library = {};
  double same_rate_ratio = std::numeric_limits<double>::quiet_NaN(), same_rate_low = same_rate_ratio,
         same_rate_high = same_rate_ratio;
  double low = std::numeric_limits<double>::quiet_NaN(), high = low;  // the figure shall lie between; NaN: not asked
  std::vector<GoalEntrant> close =
      {};                     // other candidates that reach the error at up to 1.2 times their side's best cost
  MachineState machine = {};  // no timings: nothing was timed
  // Rivals' rungs that were not run: coarser ones of the same method cost many times what their engine's cheapest does.
  std::vector<std::string> left_out = {};
};

}  // namespace atwood
