// check: judge a trace that any program recorded.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/spread.hpp"
#include "reports/command_line/trace_file.hpp"
#include "reports/command_line/verdicts.hpp"
#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "scene/printable.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {

namespace {

// Without a truth: how far the trace and the engines' runs are apart.
int check_without_truth(const Place& place, const Options& options, const Scenario& scenario, Recording run,
                        const Truth& truth) {
  const bool asked = !options.limits.empty() || !options.tolerances.empty() || options.as_method != "check";
  const bool lost = truth.outcome.status != Status::unsupported;  // it hung or crashed: it might have judged
  fmt::print(stderr, "atwood: no truth for `{}`: {}; {}\n", scenario.id, printable(truth.outcome.reason),
             asked ? "what was asked cannot be judged" : "no gate was asked for: nothing was judged");
  const auto samples = static_cast<std::int64_t>(run.values.size() - 1);
  std::vector<NamedRun> runs{{options.input, std::move(run)}};
  for (NamedRun& other : run_engines(scenario, samples, require_workers(place, options), 20))
    runs.push_back(std::move(other));
  const std::vector<std::string> lines = spread_lines(runs, true);
  if (options.json) fmt::print("{}\n", nlohmann::json{{"spread", lines}}.dump(2));
  else
    for (const std::string& line : lines) fmt::print("{}\n", line);
  return asked || lost ? exit_gate : exit_pass;
}

std::vector<Gate> limits_as_gates(const Options& options, const Scenario& scenario) {
  std::vector<Gate> gates;
  for (const auto& limit : options.limits) {
    const auto equals = limit.find('=');
    Gate gate;
    gate.scenario = scenario.id;
    gate.method = options.as_method;
    gate.metric = limit.substr(0, equals);
    gate.kind = Gate::Kind::max;
    gate.reason = "--max " + limit;
    gate.origin = "command line";
    try {
      gate.high = static_cast<double>(parse_wide(equals == std::string::npos ? "" : limit.substr(equals + 1)));
    } catch (const std::invalid_argument&) {
      throw InputError(fmt::format("--max {}: expected METRIC=VALUE", limit));
    }
    if (!std::isfinite(gate.high))
      throw InputError(
          fmt::format("--max {}: found `{}`; expected a number that is finite", limit, limit.substr(equals + 1)));
    std::vector<std::string> known;
    for (const auto& metric : all_metrics()) known.push_back(metric.name);
    if (std::find(known.begin(), known.end(), gate.metric) == known.end()) {
      throw InputError(fmt::format("--max {}: no metric `{}`{}; `atwood list metrics` shows all", limit, gate.metric,
                                   nearest_hint(gate.metric, known, 1)));
    }
    gates.push_back(gate);
  }
  return gates;
}

}  // namespace

std::string not_finite_words(const Recording& run, const Scene& scene) {
  const auto finite = [](const auto& values) {
    return std::all_of(values.begin(), values.end(),
                       [](const Wide& x) { return std::isfinite(static_cast<double>(x)); });
  };
  for (const SampleView sample : run.values) {
    for (std::size_t i = 0; i < sample.bodies.size(); ++i) {
      const BodySample& body = sample.bodies[i];
      if (!finite(body.p_m) || !finite(body.q_wxyz) || !finite(body.v_m_per_s) || !finite(body.w_rad_per_s))
        return fmt::format("body `{}` is not finite at t = {} s",
                           i < scene.bodies.size() ? scene.bodies[i].name : scene.problem,
                           format_double(static_cast<double>(sample.t_s)));
    }
  }
  return "";
}

int command_check(const Place& place, const Options& options) {
  require_outputs_make_sense(options);
  Scenario scenario = read_scene_argument(place, options.scenarios.front());
  require_own_id(place, scenario);
  const Trace trace =
      read_trace(read_input_file(options.input, "a trace (CSV)", largest::kTrace), options.input, scenario.scene);
  const std::vector<std::string>& header = trace.columns;
  Recording run = trace.run;
  const std::vector<Gate> limits = limits_as_gates(options, scenario);
  const std::string not_finite = not_finite_words(run, scenario.scene);
  const double t_end = static_cast<double>(run.values.back().t_s);
  if (t_end > scenario.t_end_s * (1 + 1e-9))
    throw InputError(fmt::format("{}: t_s: found t = {} s; expected times up to the scenario's end, {} s",
                                 options.input, format_double(t_end), format_double(scenario.t_end_s)));
  if (std::abs(t_end - scenario.t_end_s) > 1e-12 * scenario.t_end_s) scenario.t_end_s = t_end;
  const auto samples = static_cast<std::int64_t>(run.values.size() - 1);
  Truth truth = truth_once(place.truth_worker, scenario, samples, 120);
  if (truth.outcome.status != Status::ok) {
    if (!not_finite.empty()) {
      fmt::print(stderr, "atwood: {}: {}\n", printable(options.input), printable(not_finite));
      return exit_gate;
    }
    return check_without_truth(place, options, scenario, std::move(run), truth);
  }

  auto rows = measure(scenario, truth, run);
  auto lacks = [&](const char* name) { return std::find(header.begin(), header.end(), name) == header.end(); };
  std::erase_if(rows, [&](const Row& row) {  // what was not recorded is not judged
    const bool of_attitude = row.metric.find("attitude") != std::string::npos;
    const bool of_rate = row.metric.find("body-rate") != std::string::npos || row.metric.find("energy") == 0 ||
                         row.metric.find("angular-momentum") == 0;
    return (of_attitude && lacks("qw")) || (of_rate && lacks("wx_rad_per_s") &&
                                            std::any_of(scenario.scene.bodies.begin(), scenario.scene.bodies.end(),
                                                        [](const Body& b) { return rotates(b); }));
  });
  for (auto& row : rows) {
    row.scenario = scenario.id;
    row.method = options.as_method;
    row.steps = samples;
    row.h_s = t_end / static_cast<double>(samples);
    row.provenance = place.provenance;
  }
  Selection selection;
  selection.scenarios = {scenario};
  selection.narrowed = true;
  selection.tolerances = options.tolerances;
  Cell cell;
  cell.scenario = std::make_shared<const Scenario>(scenario);
  cell.method = options.as_method;
  cell.plan = {t_end, samples, samples};
  selection.cells = {cell};
  auto verdicts = judge_selection(place, options, selection, rows);
  // One run has no ladder: gates on orders and growth, and gates bound to a step count, are not about it.
  std::erase_if(verdicts, [](const Verdict& verdict) {
    return verdict.judgement == Judgement::not_run &&
           (verdict.gate.metric.rfind("order-", 0) == 0 || verdict.gate.metric.rfind("growth-", 0) == 0 ||
            verdict.gate.metric == "step-time" || verdict.gate.metric == "rate-evaluations");
  });
  const auto own = judge(limits, rows);
  verdicts.insert(verdicts.end(), own.begin(), own.end());
  for (auto& verdict : verdicts) verdict.rerun = options.words;

  if (options.json) {
    ReportData data;
    data.title = "check " + options.input;
    data.command = options.program;
    data.program = shell_line(std::vector{options.words.front()});
    data.provenance = place.provenance;
    data.scenarios = {scenario};
    data.rows = rows;
    data.verdicts = verdicts;
    fmt::print("{}\n", render_json(data));
  } else {
    for (const auto& row : rows) {
      fmt::print("{:<28} {:>24} {:<8} bar {}\n", row.metric, format_double(row.value), row.unit,
                 fmt::format("{:.2g}", row.truth_bar));
    }
    fmt::print("\n");
    if (verdicts.empty())
      fmt::print("no gate applies: nothing was judged (--max METRIC=VALUE, --tolerances FILE or --as METHOD)\n");
    else fmt::print("{}", render_verdict_table(verdicts, rows, use_colour(STDOUT_FILENO), terminal_width()));
  }
  if (!options.junit.empty()) write_file(options.junit, render_junit(verdicts));
  if (not_finite.empty()) return gate_exit(verdicts);
  fmt::print(stderr, "atwood: {}: {}\n", printable(options.input), printable(not_finite));
  return std::max(gate_exit(verdicts), static_cast<int>(exit_gate));
}

}  // namespace atwood
