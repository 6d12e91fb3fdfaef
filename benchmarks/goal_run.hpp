// Measures a goal and its rivals in one run: first accuracy, by the store as in a study; then the methods that are
// accurate enough are timed alternately.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "benchmarks/figures.hpp"
#include "benchmarks/goals.hpp"
#include "scene/scene.hpp"
#include "validation/study/study.hpp"

namespace atwood {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

struct GoalSetup {
  const std::vector<Worker>& workers;
  StudyOptions study;  // store, limits, progress; with `timing` false nothing is timed
  std::function<Scenario(const std::string&)> scenario;  // of a catalogue id or a file; throws InputError
  std::function<void()> end_progress = [] {};            // after each study
};

// The result of a goal with a scenario. Throws Interrupted; InputError where the scene cannot be read.
GoalResult run_goal(const GoalSetup& setup, const Goal& goal);

// A result with the goal's requirements and no figures.
GoalResult blank_result(const Goal& goal);
// The result of a goal with a `benchmark`: its figure over `per` (nanoseconds per body or pair).
GoalResult judge_figure(const Goal& goal, const std::vector<BenchFigure>& figures);
// The result of a goal with a `table`: one cell of it.
GoalResult judge_table(const Goal& goal, const std::vector<BenchTable>& tables);
// The names of the benchmarks that a goal needs, as Google Benchmark's filter; empty: none.
std::string benchmark_filter(const Goal& goal);

}  // namespace atwood
