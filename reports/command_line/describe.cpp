// describe: a scene, a method with its claims and settings, or a metric's definition.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/manual.hpp"
#include "reports/command_line/method_words.hpp"
#include "reports/command_line/program.hpp"
#include "reports/command_line/scene_summary.hpp"
#include "scene/files.hpp"
#include "validation/metrics/metric_origin.hpp"

namespace atwood {
namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

namespace {

// The method that the words name, when they name one that an engine offers or could offer; no scene has `/` and no
// file.
bool names_method(const std::string& text) {
  if (text.find('/') == std::string::npos || fs::exists(text) || text.ends_with(".toml") || text.ends_with(".json"))
    return false;
  try {
    parse_method_id(text);
    return true;
  } catch (const std::invalid_argument& error) {
    if (text.find_first_of("+@:{") == std::string::npos) return false;  // a scene's file that is not there
    throw InputError(fmt::format("describe {}: {}", text, without_id(error, text)));
  }
}

// The equations as an indented block, one a line, unwrapped.
std::string formula_block(const std::string& formula) {
  if (formula.empty()) return "";
  std::string text = "  Formula:\n";
  for (std::size_t at = 0; at < formula.size();) {
    const std::size_t end = std::min(formula.find('\n', at), formula.size());
    text += "    " + formula.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return text;
}

void print_method(const MethodInfo& info, const Engine& engine, const std::string& asked) {
  const auto width = static_cast<std::size_t>(std::clamp(terminal_width(), 60, 120));
  fmt::print("{}{}\n  engine:  {} {}, {}\n  order:   {}\n{}", asked,
             info.adaptive ? "  (takes a tolerance: [:rtol[,atol]])" : "", engine.name, engine.version, engine.scalar,
             claims_words(info), wrapped(info.doc, 2, width) + formula_block(info.formula));
  if (!info.source.empty()) fmt::print("{}", wrapped("Source: " + info.source, 2, width));
  if (!info.settings.empty()) fmt::print("  settings:\n");
  fmt::print("{}", settings_text(info, width));
}

// The contact response after the plus; null where the id has none.
const MethodInfo* response_of(const Engine& engine, const MethodId& id, const std::string& asked) {
  if (id.response.empty()) return nullptr;
  std::vector<std::string> known;
  for (const auto& info : engine.responses) {
    if (info.id == "+" + id.response) return &info;
    known.push_back(info.id);
  }
  throw InputError(
      fmt::format("describe {}: {} has no response `+{}`; expected {}", asked, engine.name, id.response,
                  known.empty() ? "none: the engine resolves contacts itself" : "one of " + join(known, ", ")));
}

void print_response(const MethodInfo& info) {
  const auto width = static_cast<std::size_t>(std::clamp(terminal_width(), 60, 120));
  fmt::print("\n{}\n{}{}", info.id, wrapped(info.doc, 2, width), formula_block(info.formula));
  if (!info.source.empty()) fmt::print("{}", wrapped("Source: " + info.source, 2, width));
  fmt::print("  settings:\n");
  fmt::print("{}", settings_text(info, width));
}

int describe_method(const Place& place, const Options& options) {
  const MethodId id = parse_method_id(options.input);
  const std::string base = id.engine + "/" + id.scheme;
  const std::vector<Worker> workers = require_workers(place, options);
  require_answers(workers);
  for (const auto& worker : workers) {
    if (worker.status != Status::ok) continue;
    for (const auto& info : worker.engine.methods) {
      if (info.id != base) continue;
      const MethodInfo* response = response_of(worker.engine, id, options.input);
      check_settings("describe ", options.input, workers);
      if (options.evidence) {
        const Scenario scenario =
            read_scene_argument(place, options.scenarios.empty() ? "kepler-e0.6" : options.scenarios.front());
        const Truth truth = truth_once(place.truth_worker, scenario, 1, 120);
        if (truth.values.empty())
          throw InputError(fmt::format("--program: no truth of `{}`: {}", scenario.id, truth.outcome.reason));
        fmt::print("{}", evidence_program(id, info, worker.engine.version, scenario, truth));
      } else if (options.json) {
        json out = method_json(info);
        if (response) out["response"] = method_json(*response);
        fmt::print("{}\n", out.dump(2));
      } else {
        print_method(info, worker.engine, options.input);
        if (response) print_response(*response);
      }
      return exit_pass;
    }
  }
  refuse_unknown_method("describe ", options.input, workers);
}

// The metric of this name; nullptr where the text names a file or a scene of the catalogue. InputError where it names
// neither.
const MetricInfo* named_metric(const Place& place, const std::string& text) {
  const fs::path in_catalogue = catalogue_file(place, text);
  if (text.find('/') != std::string::npos || fs::exists(text) || fs::exists(in_catalogue)) return nullptr;
  if (text.ends_with(".toml")) return nullptr;
  std::vector<std::string> names;
  for (const std::string& folder : catalogue_folders(place))
    for (std::string& name : file_stems(folder)) names.push_back(std::move(name));
  for (const MetricInfo& metric : all_metrics()) {
    if (metric.name == text) return &metric;
    names.push_back(metric.name);
  }
  throw InputError(
      fmt::format("describe {}: no file, scene or metric has this name{}; `atwood list` shows all; a method is written "
                  "ENGINE/METHOD, as in atwood/rk4",
                  text.empty() ? "\"\"" : text, nearest_hint(text, names, 3)));
}

void describe_metric(const MetricInfo& metric, const Options& options) {
  const auto [formula, source] = origin_of(metric.name);
  if (options.json) {
    fmt::print("{}\n", json{{"name", metric.name},
                            {"unit", metric.unit},
                            {"definition", metric.definition},
                            {"formula", formula},
                            {"source", source}}
                           .dump(2));
    return;
  }
  const auto width = static_cast<std::size_t>(std::clamp(terminal_width(), 50, 110));
  fmt::print("{} [{}]\n{}", metric.name, metric.unit == "1" ? "a ratio or a count, without unit" : metric.unit,
             wrapped(metric.definition, 2, width));
  if (!formula.empty())
    fmt::print("{}{}", wrapped("Formula: " + formula, 2, width), wrapped("Source: " + source, 2, width));
}

}  // namespace

int command_describe(const Place& place, const Options& options) {
  if (names_method(options.input)) return describe_method(place, options);
  if (const MetricInfo* metric = named_metric(place, options.input)) {
    describe_metric(*metric, options);
    return exit_pass;
  }
  if (options.evidence)
    throw InputError(fmt::format("--program is about a library's method, as in arkode/erkstep/VERNER_8_5_6; found `{}`",
                                 options.input));
  const Scenario scenario = read_scene_argument(place, options.input);
  note_shared_id(place, scenario);
  if (options.json) {
    fmt::print("{}\n", scenario_to_json(scenario));
    return exit_pass;
  }
  fmt::print("{}", scene_summary(place, scenario, require_workers(place, options), terminal_width()));
  return exit_pass;
}

}  // namespace atwood
