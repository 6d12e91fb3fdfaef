// list: scenarios, methods, metrics, gates and studies.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "protocol/solver_report.hpp"
#include "reports/command_line/command_line.hpp"
#include "reports/command_line/manual.hpp"
#include "reports/command_line/method_words.hpp"
#include "scene/files.hpp"
#include "validation/metrics/metric_origin.hpp"

namespace atwood {
namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

namespace {

json gate_json(const Gate& gate) {
  json out = {{"scenario", gate.scenario}, {"method", gate.method}, {"metric", gate.metric}};
  if (gate.steps) out["steps"] = *gate.steps;
  switch (gate.kind) {
    case Gate::Kind::within: out["within"] = {gate.low, gate.high}; break;
    case Gate::Kind::max: out["max"] = gate.high; break;
    case Gate::Kind::min: out["min"] = gate.low; break;
    case Gate::Kind::within_claim: out["within_claim"] = gate.claim; break;
    case Gate::Kind::max_ratio: out["max_ratio"] = {{"to", gate.ratio_to}, {"value", gate.high}}; break;
  }
  out["reason"] = gate.reason;
  return out;
}

json list_json(const Place& place, const Options& options, const std::string& what) {
  json out = json::object();
  if (what.empty() || what == "scenarios") {
    for (const auto& s : read_catalogue(place)) {
      out["scenarios"].push_back({{"id", s.id},
                                  {"title", s.title},
                                  {"claim", s.claim},
                                  {"tags", s.tags},
                                  {"steps", s.steps},
                                  {"samples", s.samples},
                                  {"t_end_s", s.t_end_s}});
    }
  }
  if (what.empty() || what == "methods") {
    for (const auto& worker : require_workers(place, options)) {
      for (const auto& info : worker.engine.methods) out["methods"].push_back(method_json(info));
      for (const auto& info : worker.engine.responses) out["responses"].push_back(method_json(info));
    }
  }
  if (what.empty() || what == "metrics") {
    for (const auto& m : all_metrics()) {
      const auto [formula, source] = origin_of(m.name);
      out["metrics"].push_back(
          {{"name", m.name}, {"unit", m.unit}, {"definition", m.definition}, {"formula", formula}, {"source", source}});
    }
  }
  if (what.empty() || what == "gates") {
    for (const auto& gate : read_all_gates(place)) out["gates"].push_back(gate_json(gate));
  }
  return out;
}

// Claimed orders: points under forces of position, points under forces that depend on velocity, rotating bodies,
// mechanisms, fluids.
std::string orders_text(const MethodInfo& info) {
  if (info.claimed_order.empty()) return "-";
  std::string text;
  for (const char* motion : {"point-mass", "velocity-dependent", "rotation", "mechanism", "fluid"}) {
    const auto found = info.claimed_order.find(motion);
    text += (text.empty() ? "" : " ") + (found == info.claimed_order.end() ? "-" : fmt::format("{:g}", found->second));
  }
  return text;
}

std::string cut(const std::string& text, std::size_t width) {
  return text.size() <= width ? text : text.substr(0, width - 3) + "...";
}

// One line for each method: as much of its documentation as the width allows.
void print_methods_table(const Place& place, const Options& options) {
  const auto width = static_cast<std::size_t>(std::clamp(terminal_width(), 60, 120));
  const std::vector<Worker> workers = require_workers(place, options);
  std::size_t column = 20;
  for (const Worker& worker : workers)
    for (const MethodInfo& info : worker.engine.methods) column = std::max(column, info.id.size());
  column = std::min<std::size_t>(column, width < 66 ? 30 : 34);
  constexpr std::size_t orders_width = 14, columns_width = 1 + orders_width + 1 + 4;
  const auto line = [&](const std::string& id, const std::string& orders, bool adaptive, const std::string& doc) {
    const bool apart = id.size() > column && id.size() + columns_width + 8 > width;  // a long id has a line of its own
    const std::size_t taken = (apart ? column : std::max(column, id.size())) + columns_width;
    if (apart) fmt::print("{}\n", id);
    fmt::print("{:<{}} {:<{}} {:<4}{}\n", apart ? "" : id, column, orders, orders_width, adaptive ? "tol" : "",
               taken + 8 < width ? cut(doc, width - taken) : cut(doc, 8));
  };
  line("method", "orders", false, "what it is");
  for (const Worker& worker : workers) {
    if (worker.status != Status::ok) {
      fmt::print("{}", wrapped(fmt::format("{}: {}: {}", fs::path(worker.path).filename().string(),
                                           to_string(worker.status), worker.reason),
                               0, width));
      continue;
    }
    for (const MethodInfo& info : worker.engine.methods) line(info.id, orders_text(info), info.adaptive, info.doc);
    for (const MethodInfo& info : worker.engine.responses)
      line(worker.engine.name + "/..." + info.id, "", false, info.doc);
  }
  line("truth", "", false, "the scene's certified truth, for `atwood trace`");
  fmt::print(
      "\n{}",
      wrapped(
          "orders: claimed for points under forces of position, for points under forces that depend on velocity, "
          "for rotating bodies, for mechanisms of joints and for fluids (with +sph and +polynomial at most the ceiling of the "
          "kernel: cubic 3, wendland-c2 4, quintic 5, wendland-c4 6, wendland-c6 8); -: no claim. tol: takes a tolerance, as in atwood/dopri5:1e-8. `--long` "
          "prints documentation, sources and settings, `atwood describe METHOD` those of one method.",
          0, width));
}

void print_studies(const Place& place, const Options& options) {
  json out = json::array();
  for (const std::string& id : file_stems(place.source_dir + "/validation/study")) {
    const Study study = read_study(place.source_dir + "/validation/study/" + id + ".toml");
    if (options.json) out.push_back({{"id", study.id}, {"blocks", study.cells.size()}});
    else fmt::print("{:<20} {} block{} of cells\n", id, study.cells.size(), study.cells.size() == 1 ? "" : "s");
  }
  if (options.json) fmt::print("{}\n", json{{"studies", out}}.dump(2));
}

// One name a line, as completion reads them.
void print_names(const Place& place, const Options& options) {
  std::vector<std::string> names;
  if (options.input == "scenarios")
    for (const std::string& folder : catalogue_folders(place))
      for (std::string& name : file_stems(folder)) names.push_back(std::move(name));
  if (options.input == "studies") names = file_stems(place.source_dir + "/validation/study");
  if (options.input == "methods") {
    for (const Worker& worker : require_workers(place, options))
      for (const MethodInfo& info : worker.engine.methods) names.push_back(info.id);
    names.push_back("truth");
  }
  if (options.input == "metrics")
    for (const MetricInfo& metric : all_metrics()) names.push_back(metric.name);
  for (const std::string& name : names) fmt::print("{}\n", name);
}

void print_description(const MethodInfo& info, std::size_t width) {
  fmt::print("{}", wrapped(info.doc, 4, width));
  if (!info.source.empty()) fmt::print("{}", wrapped("Source: " + info.source, 4, width));
  fmt::print("{}", settings_text(info, width));
  fmt::print("\n");
}

void print_methods(const Place& place, const Options& options) {
  const auto width = static_cast<std::size_t>(std::clamp(terminal_width(), 60, 120));
  for (const auto& worker : require_workers(place, options)) {
    if (worker.status != Status::ok) {
      fmt::print("{}: {}: {}\n", fs::path(worker.path).filename().string(), to_string(worker.status), worker.reason);
      continue;
    }
    for (const auto& info : worker.engine.methods) {
      fmt::print("{}{}\n    order: {}\n", info.id, info.adaptive ? "[:rtol[,atol]]" : "", claims_words(info));
      print_description(info, width);
    }
    for (const auto& info : worker.engine.responses) {
      fmt::print("{}/...{}\n    a response, written behind a method of {}\n", worker.engine.name, info.id,
                 worker.engine.name);
      print_description(info, width);
    }
  }
  fmt::print(
      "truth\n    The scene's certified truth, with a bar on every value (`atwood trace SCENE --method truth`).\n");
}

}  // namespace

int command_list(const Place& place, const Options& options) {
  const std::string what = options.input;
  if (!what.empty() && what != "scenarios" && what != "methods" && what != "metrics" && what != "gates" &&
      what != "studies") {
    throw InputError(fmt::format("list: found `{}`; expected scenarios, methods, metrics, gates or studies{}", what,
                                 nearest_hint(what, {"scenarios", "methods", "metrics", "gates", "studies"}, 1)));
  }
  if (options.names) {
    print_names(place, options);
    return exit_pass;
  }
  if (what == "studies") {
    print_studies(place, options);
    return exit_pass;
  }
  if (options.json) {
    fmt::print("{}\n", list_json(place, options, what).dump(2));
    return exit_pass;
  }
  if (what.empty() || what == "scenarios") {
    for (const auto& s : read_catalogue(place)) fmt::print("{:<28} {}  [{}]\n", s.id, s.title, join(s.tags, " "));
  }
  if (what.empty()) fmt::print("\n");
  if (what.empty() || what == "methods") {
    if (options.long_list) print_methods(place, options);
    else print_methods_table(place, options);
  }
  if (what.empty()) fmt::print("\n");
  if (what.empty() || what == "metrics") {
    const auto width = static_cast<std::size_t>(std::clamp(terminal_width(), 60, 120));
    for (const auto& m : all_metrics()) fmt::print("{} [{}]\n{}", m.name, m.unit, wrapped(m.definition, 4, width));
    fmt::print("\nsolvers that the solver-* metrics name in `body`: what they solve, and the scale of the residual\n");
    for (const SolverInfo& solver : solver_infos())
      fmt::print("{}\n{}", solver.name,
                 wrapped(fmt::format("{}. Residual: {}.", solver.solves, solver.residual), 4, width));
  }
  if (what.empty()) fmt::print("\n");
  if (what.empty() || what == "gates") {
    for (const auto& gate : read_all_gates(place)) {
      json shown = gate_json(gate);
      for (const char* key : {"scenario", "method", "metric", "reason"}) shown.erase(key);
      fmt::print("{} {} {} {}  {}\n", gate.scenario, gate.method, gate.metric, shown.dump(), gate.reason);
    }
  }
  return exit_pass;
}

}  // namespace atwood
