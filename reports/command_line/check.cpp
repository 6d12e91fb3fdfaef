// check: judge a trace that any program recorded.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/spread.hpp"
#include "reports/command_line/verdicts.hpp"
#include "scene/csv.hpp"
#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "scene/printable.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {

namespace {

struct Columns {
  std::map<std::string, std::size_t> at;
  bool has(const char* name) const { return at.contains(name); }
};

template <std::size_t n>
void read_group(const std::array<const char*, n>& names, const Columns& columns, const std::vector<std::string>& fields,
                const std::string& where, std::array<Wide, n>& out) {
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t column = columns.at.at(names[i]);
    try {
      out[i] = parse_wide(fields.at(column));
    } catch (const std::exception&) {
      throw InputError(fmt::format("{}:{}: {}: found `{}`; expected a number", where, column + 1, names[i],
                                   column < fields.size() ? fields[column] : "nothing"));
    }
  }
}

constexpr std::array<const char*, 3> kPNames{"px_m", "py_m", "pz_m"};
constexpr std::array<const char*, 4> kQNames{"qw", "qx", "qy", "qz"};
constexpr std::array<const char*, 3> kVNames{"vx_m_per_s", "vy_m_per_s", "vz_m_per_s"};
constexpr std::array<const char*, 3> kWNames{"wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"};

Columns read_header(const std::vector<std::string>& names, const std::string& path) {
  Columns columns;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!columns.at.emplace(names[i], i).second)
      throw InputError(fmt::format("{}:1:{}: column `{}` appears twice", path, i + 1, names[i]));
  }
  auto require = [&](const char* name) {
    if (!columns.has(name))
      throw InputError(fmt::format("{}:1:1: found no column `{}`; expected the columns of `atwood trace`", path, name));
  };
  require("t_s");
  require("body");
  for (const char* name : kPNames) require(name);
  for (const char* name : kVNames) require(name);
  auto all_or_none = [&](const auto& group) {  // half an orientation is a mistake, not an omission
    if (std::any_of(group.begin(), group.end(), [&](const char* name) { return columns.has(name); })) {
      for (const char* name : group) require(name);
    }
  };
  all_or_none(kQNames);
  all_or_none(kWNames);
  return columns;
}

// Rows may come in any order within one instant; instants must rise and be the same for every body.
Recording read_trace(CsvReader& file, const Columns& columns, const std::string& path, const Scene& scene) {
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) index[scene.bodies[i].name] = i;

  Recording run;
  std::vector<bool> seen;
  auto complete = [&](int number) {
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!seen[i] && !scene.bodies[i].fixed) {
        throw InputError(fmt::format("{}:{}: found no row for body `{}` at the instant before this line", path, number,
                                     scene.bodies[i].name));
      }
    }
  };
  std::vector<std::string> fields;
  while (file.next(fields)) {
    const int number = file.line();
    const std::string where = fmt::format("{}:{}", path, number);
    if (fields.size() != columns.at.size()) {
      throw InputError(
          fmt::format("{}: found {} fields; expected {}, as in the header", where, fields.size(), columns.at.size()));
    }
    std::array<Wide, 1> t{};
    read_group<1>({"t_s"}, columns, fields, where, t);
    const std::size_t t_column = columns.at.at("t_s");
    if (!std::isfinite(static_cast<double>(t[0])))
      throw InputError(fmt::format("{}:{}: t_s: found `{}`; expected a time that a double holds, finite", where,
                                   t_column + 1, fields[t_column]));
    const std::string name = unguarded_cell(fields.at(columns.at.at("body")));
    if (!index.contains(name))
      throw InputError(fmt::format("{}: found body `{}`, which the scene does not have", where, name));
    if (run.values.empty() || t[0] != run.values.back().t_s) {
      if (!run.values.empty()) {
        complete(number);
        if (!(t[0] > run.values.back().t_s))
          throw InputError(
              fmt::format("{}:{}: t_s: found `{}`; expected times that rise", where, t_column + 1, fields[t_column]));
      }
      run.values.push_back({t[0], std::vector<BodySample>(scene.bodies.size())});
      for (std::size_t i = 0; i < scene.bodies.size(); ++i) {  // fixed bodies need no rows
        for (std::size_t k = 0; k < 3; ++k) run.values.back().bodies[i].p_m[k] = scene.bodies[i].position_m[k];
        for (std::size_t k = 0; k < 4; ++k) run.values.back().bodies[i].q_wxyz[k] = scene.bodies[i].orientation_wxyz[k];
      }
      seen.assign(scene.bodies.size(), false);
    }
    BodySample& body = run.values.back().bodies[index[name]];
    if (seen[index[name]]) throw InputError(fmt::format("{}: body `{}` appears twice at this instant", where, name));
    seen[index[name]] = true;
    read_group(kPNames, columns, fields, where, body.p_m);
    read_group(kVNames, columns, fields, where, body.v_m_per_s);
    if (columns.has("qw")) read_group(kQNames, columns, fields, where, body.q_wxyz);
    if (columns.has("wx_rad_per_s")) read_group(kWNames, columns, fields, where, body.w_rad_per_s);
  }
  if (run.values.size() < 2)
    throw InputError(fmt::format("{}: found {} instants; expected at least two", path, run.values.size()));
  complete(file.line() + 1);
  return run;
}

// The truth is solved at equal intervals: the trace must be sampled so, from 0 on.
void require_even(const Recording& run, const std::string& path) {
  const double t_end = static_cast<double>(run.values.back().t_s);
  const auto samples = static_cast<double>(run.values.size() - 1);
  for (std::size_t k = 0; k < run.values.size(); ++k) {
    const double expected = t_end * static_cast<double>(k) / samples;
    if (std::abs(static_cast<double>(run.values[k].t_s) - expected) > 1e-12 * t_end) {
      throw InputError(fmt::format("{}: found instant {} at t = {} s; expected {} s (equal intervals from 0)", path, k,
                                   format_double(static_cast<double>(run.values[k].t_s)), format_double(expected)));
    }
  }
}

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
  for (const Sample& sample : run.values) {
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
  CsvReader file(read_input_file(options.input, "a trace (CSV)", largest::kTrace));
  std::vector<std::string> header;
  if (!file.next(header))
    throw InputError(fmt::format("{}:1:1: found an empty file; expected a header line", options.input));
  Recording run = read_trace(file, read_header(header, options.input), options.input, scenario.scene);
  require_even(run, options.input);
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
