// `bench`: runs the measurements of benchmarks/, prints their figures and keeps them for the report.
#include <algorithm>
#include <cstdio>
#include <regex>

#include <fmt/format.h>

#include "benchmarks/bench_file.hpp"
#include "benchmarks/fluid_budget.hpp"
#include "benchmarks/frame_budget.hpp"
#include "benchmarks/goal_run.hpp"
#include "benchmarks/programs.hpp"
#include "reports/command_line/command_line.hpp"
#include "scene/files.hpp"
#include "validation/study/process.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {
namespace {

std::string bench_path(const Options& options) { return options.out_dir + "/bench.json"; }

void notice(const std::string& text) { fmt::print(stderr, "atwood: {}\n", text); }

// Prints the tables and keeps them for the report.
void show_bench_tables(const Place& place, const Options& options, const std::vector<BenchTable>& tables) {
  for (const BenchTable& table : tables) {
    keep_bench_table(bench_path(options), place.provenance, table);
    if (!options.json) fmt::print("{}\n", render_bench_table(table));
  }
  if (options.json) fmt::print("{}\n", bench_tables_json(tables));
  else fmt::print("{}; `atwood report` shows them\n", bench_path(options));
}

std::vector<Goal> chosen_goals(const Place& place, const Options& options) {
  std::vector<Goal> goals =
      read_goals(options.goals_file.empty() ? place.source_dir + "/benchmarks/goals.toml" : options.goals_file);
  if (options.goals.empty()) return goals;
  std::vector<std::string> ids;
  for (const Goal& goal : goals) ids.push_back(goal.id);
  for (const std::string& pattern : options.goals) {
    if (std::any_of(ids.begin(), ids.end(), [&](const std::string& id) { return glob_match(pattern, id); })) continue;
    throw InputError(fmt::format("--goal {}: no goal has this id{}", pattern, nearest_hint(pattern, ids, 4)));
  }
  std::erase_if(goals, [&](const Goal& goal) {
    return std::none_of(options.goals.begin(), options.goals.end(),
                        [&](const std::string& pattern) { return glob_match(pattern, goal.id); });
  });
  return goals;
}

// One goal's result. Where its scene cannot be read, an InputError if `strict` (a file of the user's own); otherwise
// the goal counts as missed and the result says why.
GoalResult run_or_say_why(const GoalSetup& setup, const Goal& goal, bool strict) {
  try {
    return run_goal(setup, goal);
  } catch (const InputError& error) {
    if (strict) throw;
    GoalResult result = blank_result(goal);
    result.why = error.what();
    return result;
  }
}

// The benchmarks of one goal in processes of their own: a figure does not depend on which other goals are measured.
GoalResult run_benchmark_goal(const Place& place, const Options& options, const Goal& goal) {
  if (options.no_timing) return judge_figure(goal, {});
  const auto measured = calmest_benchmarks(place.worker_dir, benchmark_filter(goal));
  GoalResult result = judge_figure(goal, measured.figures);
  result.machine = measured.machine;
  return result;
}

}  // namespace

int command_goals(const Place& place, const Options& options) {
  const std::vector<Goal> goals = chosen_goals(place, options);
  Options chosen = options;
  chosen.with_same_rate = true;
  const std::vector<Worker> workers = require_workers(place, chosen);
  make_out_dir(options.out_dir);
  const InterruptGuard guard;
  GoalSetup setup{workers, study_options(place, options),
                  [&](const std::string& scenario) { return read_scene_argument(place, scenario); }, end_progress};
  setup.study.progress = progress_printer(options);
  std::vector<GoalResult> results;
  std::vector<BenchTable> tables;
  try {
    for (const Goal& goal : goals) {
      notice("goal " + goal.id);
      if (goal.table == "broad-phases" && tables.empty()) tables = measure_broad_phases(place.worker_dir);
      if (!goal.table.empty()) results.push_back(judge_table(goal, tables));
      else if (!goal.benchmark.empty()) results.push_back(run_benchmark_goal(place, options, goal));
      else results.push_back(run_or_say_why(setup, goal, !options.goals_file.empty()));
    }
  } catch (const Interrupted&) {
    if (!results.empty()) fmt::print("{}", goals_text(results));
    notice("interrupted; goals that were not measured yet are left out");
    return 128 + interrupt_signal();
  }
  keep_bench(bench_path(options), place.provenance, nullptr, &results);
  if (options.json) {
    ReportData data;
    data.title = "Atwood: goals";
    data.command = options.program;
    data.program = shell_line(std::vector{options.words.front()});
    data.provenance = place.provenance;
    data.goals = results;
    fmt::print("{}\n", render_json(data));
  } else {
    fmt::print("{}\n{}; `atwood report` shows them\n", goals_text(results), bench_path(options));
  }
  return exit_pass;
}

int command_broad_phases(const Place& place, const Options& options) {
  show_bench_tables(place, options, measure_broad_phases(place.worker_dir));
  return exit_pass;
}

int command_frame_budget(const Place& place, const Options& options) {
  const std::vector<Worker> workers = require_workers(place, options);
  make_out_dir(options.out_dir);
  const InterruptGuard guard;
  const BrokenPipeGuard pipes;
  const FrameBudgetSetup setup{workers,
                               options.methods,
                               read_scene_argument(place, "settling-100").scene,
                               read_scene_argument(place, "settling-boxes-100").scene,
                               options.cell_limit_s,
                               notice};
  FrameBudgetTables measured = measure_frame_budget(setup);
  if (!measured.interrupted) {
    const FrameBudgetTables fluids = measure_fluid_budget(setup);
    measured.tables.insert(measured.tables.end(), fluids.tables.begin(), fluids.tables.end());
    measured.interrupted = fluids.interrupted;
    measured.failed = measured.failed || fluids.failed;
  }
  show_bench_tables(place, options, measured.tables);
  if (!measured.interrupted) return measured.failed ? exit_cell : exit_pass;
  notice("interrupted; what was not measured yet is left out");
  return 128 + interrupt_signal();
}

int command_bench(const Place& place, const Options& options) {
  if (options.input != "goals" && (!options.goals.empty() || !options.goals_file.empty()))
    throw InputError(
        fmt::format("bench: {} is an option of `bench goals` only", options.goals.empty() ? "--goals" : "--goal"));
  if (options.input == "goals") return command_goals(place, options);
  if (options.input == "broad-phases") return command_broad_phases(place, options);
  if (options.input == "frame-budget") return command_frame_budget(place, options);
  if (benchmark_programs(place.worker_dir).empty())
    throw InputError(
        "the benchmarks are not installed; run `./atwood bench` in a copy of the sources, which builds them");
  std::vector<std::string> programs;
  try {
    programs = benchmark_programs(place.worker_dir, options.input);
  } catch (const std::regex_error& error) {
    throw InputError(fmt::format("bench {}: not a regular expression: {}", options.input, error.what()));
  }
  const std::vector<BenchFigure> figures = run_benchmarks(programs, options.input, notice);
  if (figures.empty()) throw InputError(fmt::format("no benchmark matches `{}`", options.input));
  keep_bench(bench_path(options), place.provenance, &figures, nullptr);
  if (options.json) {
    fmt::print("{}", read_bench_text(bench_path(options)));
    return exit_pass;
  }
  fmt::print("{:<64} {:>14} {:>12} {:>12}\n", "benchmark", "median [ns]", "from", "to");
  for (const BenchFigure& f : figures)
    fmt::print("{:<64} {:>14.1f} {:>12.1f} {:>12.1f}\n", f.name, f.ns_per_step.value, f.ns_per_step.low,
               f.ns_per_step.high);
  fmt::print(
      "\nfrom, to: the median's interval over the repetitions (their range where they are fewer than six)\n"
      "{}; `atwood report` shows them\n",
      bench_path(options));
  return exit_pass;
}

}  // namespace atwood
