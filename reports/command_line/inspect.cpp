// list, describe, doctor, schema: what is here, without running anything.
#include <sys/statvfs.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/manual.hpp"
#include "reports/command_line/program.hpp"
#include "reports/command_line/scene_summary.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

namespace {

std::string text_of(const SettingValue& value) {
  return std::visit(
      [](const auto& v) -> std::string {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, bool>) return v ? "true" : "false";
        else if constexpr (std::is_same_v<T, double>) return format_double(v);
        else return fmt::format("{}", v);
      },
      value);
}

json json_of(const SettingValue& value) {
  return std::visit([](const auto& v) { return json(v); }, value);
}

std::string join(const std::vector<std::string>& words, const char* between) {
  return fmt::format("{}", fmt::join(words, between));
}

std::string claims_text(const MethodInfo& info) {
  std::string text;
  for (const auto& [motion, order] : info.claimed_order)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", motion, order);
  return text.empty() ? "no claim" : text;
}

json method_json(const MethodInfo& info) {
  json settings = json::object();
  for (const auto& [name, value] : info.settings) settings[name] = json_of(value);
  return {{"id", info.id},
          {"doc", info.doc},
          {"source", info.source},
          {"claimed_order", info.claimed_order},
          {"adaptive", info.adaptive},
          {"settings", settings}};
}

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
    for (const auto& m : all_metrics())
      out["metrics"].push_back({{"name", m.name}, {"unit", m.unit}, {"definition", m.definition}});
  }
  if (what.empty() || what == "gates") {
    for (const auto& gate : read_all_gates(place)) out["gates"].push_back(gate_json(gate));
  }
  return out;
}

// Orders for points under forces of position, under forces of velocity, and for bodies that turn.
std::string orders_text(const MethodInfo& info) {
  if (info.claimed_order.empty()) return "-";
  std::string text;
  for (const char* motion : {"point-mass", "velocity-dependent", "rotation"}) {
    const auto found = info.claimed_order.find(motion);
    text += (text.empty() ? "" : " ") + (found == info.claimed_order.end() ? "-" : fmt::format("{:g}", found->second));
  }
  return text;
}

std::string cut(const std::string& text, std::size_t width) {
  return text.size() <= width ? text : text.substr(0, width - 3) + "...";
}

// A line a method: as much of its documentation as there is room for.
void print_methods_table(const Place& place, const Options& options) {
  const auto width = static_cast<std::size_t>(std::clamp(terminal_width(), 60, 120));
  const std::vector<Worker> workers = require_workers(place, options);
  std::size_t column = 20;
  for (const Worker& worker : workers)
    for (const MethodInfo& info : worker.engine.methods) column = std::max(column, info.id.size());
  column = std::min<std::size_t>(column, 34);
  const auto line = [&](const std::string& id, const std::string& orders, bool adaptive, const std::string& doc) {
    const bool apart = id.size() > column && id.size() + 14 + 8 > width;  // too long a name has a line of its own
    const std::size_t taken = (apart ? column : std::max(column, id.size())) + 14;
    if (apart) fmt::print("{}\n", id);
    fmt::print("{:<{}} {:<8} {:<4}{}\n", apart ? "" : id, column, orders, adaptive ? "tol" : "",
               taken + 8 < width ? cut(doc, width - taken) : cut(doc, 8));
  };
  line("method", "orders", false, "what it is");
  for (const Worker& worker : workers) {
    if (worker.status != Status::ok) {
      fmt::print("{}", wrapped(fmt::format("{}: {} (`atwood doctor` says why)",
                                           fs::path(worker.path).filename().string(), to_string(worker.status)),
                               0, width));
      continue;
    }
    for (const MethodInfo& info : worker.engine.methods) line(info.id, orders_text(info), info.adaptive, info.doc);
    for (const MethodInfo& info : worker.engine.responses)
      line(worker.engine.name + "/..." + info.id, "", false, info.doc);
  }
  line("truth", "", false, "the scene's certified truth, for `atwood trace`");
  fmt::print("\n{}",
             wrapped("orders: claimed for points under forces of position, under forces of velocity, and for bodies "
                     "that turn; - no claim. tol: takes a tolerance, as in atwood/dopri5:1e-8. `--long` prints "
                     "documentation, sources and settings, `atwood describe METHOD` those of one.",
                     0, width));
}

std::vector<std::string> file_stems(const std::string& folder) {
  std::vector<std::string> stems;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".toml") stems.push_back(entry.path().stem().string());
  }
  std::sort(stems.begin(), stems.end());
  return stems;
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
  if (options.input == "scenarios") names = file_stems(place.source_dir + "/validation/scenarios");
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
  for (const auto& [name, value] : info.settings) fmt::print("    {} = {}\n", name, text_of(value));
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
      fmt::print("{}{}\n    order: {}\n", info.id, info.adaptive ? "[:rtol[,atol]]" : "", claims_text(info));
      print_description(info, width);
    }
    for (const auto& info : worker.engine.responses) {
      fmt::print("{}/...{}\n    what contacts do, after any method of {}\n", worker.engine.name, info.id,
                 worker.engine.name);
      print_description(info, width);
    }
  }
  fmt::print(
      "truth\n    The scene's certified truth, with a bar on every value (`atwood trace SCENE --method truth`).\n");
}

std::string worker_line(const Worker& worker) {
  const std::string name = fs::path(worker.path).filename().string();
  if (worker.status != Status::ok) return fmt::format("{:<18} {}: {}", name, to_string(worker.status), worker.reason);
  std::vector<std::string> ids;
  for (const auto& info : worker.engine.methods) ids.push_back(info.id.substr(info.id.find('/') + 1));
  return fmt::format("{:<18} {} {}, {}: {}", name, worker.engine.name, worker.engine.version, worker.engine.scalar,
                     ids.empty() ? "contacts only (atwood contacts, geometry-sweep)" : join(ids, " "));
}

}  // namespace

int command_list(const Place& place, const Options& options) {
  const std::string what = options.input;
  if (!what.empty() && what != "scenarios" && what != "methods" && what != "metrics" && what != "gates" &&
      what != "studies") {
    throw InputError(fmt::format("list {}: expected scenarios, methods, metrics, gates or studies; nearest: {}", what,
                                 nearest(what, {"scenarios", "methods", "metrics", "gates", "studies"}, 1).front()));
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
    for (const auto& m : all_metrics()) fmt::print("{:<28} [{}]  {}\n", m.name, m.unit, m.definition);
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
    if (text.find('+') == std::string::npos) return false;  // a scene's file that is not there
    throw InputError(fmt::format("describe {}: {}", text, error.what()));
  }
}

void print_method(const MethodInfo& info, const Engine& engine, const std::string& asked) {
  const auto width = static_cast<std::size_t>(std::clamp(terminal_width(), 60, 120));
  fmt::print("{}{}\n  engine:  {} {}, {}\n  order:   {}\n{}", asked,
             info.adaptive ? "  (takes a tolerance: [:rtol[,atol]])" : "", engine.name, engine.version, engine.scalar,
             claims_text(info), wrapped(info.doc, 2, width));
  if (!info.source.empty()) fmt::print("{}", wrapped("Source: " + info.source, 2, width));
  if (!info.settings.empty()) fmt::print("  settings:\n");
  for (const auto& [name, value] : info.settings) fmt::print("    {} = {}\n", name, text_of(value));
}

// What the words after the plus name; null: the method is named without any.
const MethodInfo* response_of(const Engine& engine, const MethodId& id, const std::string& asked) {
  if (id.response.empty()) return nullptr;
  std::vector<std::string> known;
  for (const auto& info : engine.responses) {
    if (info.id == "+" + id.response) return &info;
    known.push_back(info.id);
  }
  throw InputError(
      fmt::format("describe {}: {} has no response `+{}`; expected {}", asked, engine.name, id.response,
                  known.empty() ? "none: contacts are the engine's own affair" : "one of " + join(known, ", ")));
}

void print_response(const MethodInfo& info) {
  const auto width = static_cast<std::size_t>(std::clamp(terminal_width(), 60, 120));
  fmt::print("\n{}\n{}", info.id, wrapped(info.doc, 2, width));
  if (!info.source.empty()) fmt::print("{}", wrapped("Source: " + info.source, 2, width));
  fmt::print("  settings:\n");
  for (const auto& [name, value] : info.settings) fmt::print("    {} = {}\n", name, text_of(value));
}

int describe_method(const Place& place, const Options& options) {
  const MethodId id = parse_method_id(options.input);
  const std::string base = id.engine + "/" + id.scheme;
  std::vector<std::string> known;
  std::string absent;
  const std::vector<Worker> workers = require_workers(place, options);
  for (const auto& worker : workers) {
    if (worker.status != Status::ok) {
      if (fs::path(worker.path).filename().string() == "atwood-" + id.engine)
        absent = to_string(worker.status) + ": " + worker.reason;
      continue;
    }
    for (const auto& info : worker.engine.methods) {
      known.push_back(info.id);
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
  if (!absent.empty())
    throw InputError(fmt::format("describe {}: the engine {} is {}", options.input, id.engine, absent));
  throw InputError(fmt::format("describe {}: no engine offers `{}`; near it: {}", options.input, base,
                               join(nearest(base, known, 3), ", ")));
}

}  // namespace

namespace {

// The metric of this name, where no scene's file has it. Where no scene, method or metric has it and a metric comes
// nearest, an InputError that says so.
const MetricInfo* named_metric(const Place& place, const std::string& text) {
  const fs::path in_catalogue = fs::path(place.source_dir) / "validation/scenarios" / (text + ".toml");
  if (text.find('/') != std::string::npos || fs::exists(text) || fs::exists(in_catalogue)) return nullptr;
  std::vector<std::string> names = file_stems(place.source_dir + "/validation/scenarios");
  const auto scenes = static_cast<std::ptrdiff_t>(names.size());
  for (const MetricInfo& metric : all_metrics()) {
    if (metric.name == text) return &metric;
    names.push_back(metric.name);
  }
  const std::string near = nearest(text, names, 1).front();
  if (std::find(names.begin() + scenes, names.end(), near) != names.end() && !text.ends_with(".toml"))
    throw InputError(fmt::format("describe {}: no scene, method or metric of that name; nearest: {}", text,
                                 fmt::join(nearest(text, names, 3), ", ")));
  return nullptr;
}

void describe_metric(const MetricInfo& metric, const Options& options) {
  if (options.json) {
    fmt::print("{}\n", json{{"name", metric.name}, {"unit", metric.unit}, {"definition", metric.definition}}.dump(2));
    return;
  }
  const auto width = static_cast<std::size_t>(std::clamp(terminal_width(), 50, 110));
  fmt::print("{} [{}]\n{}", metric.name, metric.unit == "1" ? "a ratio or a count, without unit" : metric.unit,
             wrapped(metric.definition, 2, width));
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

namespace {

// doctor --check-store: what the store holds against its checksums, and nothing else.
int check_store_of(const Options& options) {
  const std::string path = options.out_dir + "/store.db";
  if (!fs::exists(path)) throw InputError(fmt::format("doctor --check-store: no store at {}", path));
  const std::vector<std::string> damage = check_store(path);
  if (options.json) {
    fmt::print("{}\n", json({{"store", path}, {"sound", damage.empty()}, {"damage", damage}}).dump(2));
  } else if (damage.empty()) {
    fmt::print("{}: sound, every entry as it was written\n", path);
  } else {
    for (const auto& line : damage) fmt::print("{}\n", line);
    fmt::print(
        "{}: {} damaged; `atwood run` measures damaged cells again; where the database itself is damaged, move "
        "the file away\n",
        path, damage.size() == 1 ? "1 thing is" : fmt::format("{} things are", damage.size()));
  }
  return damage.empty() ? exit_pass : exit_internal;
}

}  // namespace

int command_doctor(const Place& place, const Options& options) {
  if (options.check_store) return check_store_of(options);
  const auto workers = require_workers(place, options);
  struct statvfs disk {};
  const bool disk_known = statvfs(fs::exists(options.out_dir) ? options.out_dir.c_str() : ".", &disk) == 0;
  const double free_GiB =
      disk_known ? static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize) / (1 << 30) : 0;
  const bool truth_here = fs::exists(place.truth_worker);
  if (options.json) {
    json out = {{"commit", place.provenance.commit},
                {"compiler", place.provenance.compiler},
                {"flags", place.provenance.flags},
                {"cpu", place.provenance.cpu},
                {"cpu_features", place.provenance.cpu_features},
                {"libm", place.provenance.libm},
                {"truth", truth_here},
                {"free_GiB", free_GiB},
                {"engines", json::array()}};
    for (const auto& w : workers) {
      out["engines"].push_back({{"path", w.path},
                                {"status", to_string(w.status)},
                                {"reason", w.reason},
                                {"name", w.engine.name},
                                {"version", w.engine.version},
                                {"scalar", w.engine.scalar},
                                {"build_id", w.build_id}});
    }
    fmt::print("{}\n", out.dump(2));
  } else {
    const Provenance& from = place.provenance;
    fmt::print("commit    {}\ncompiler  {}\nflags     {}\ncpu       {}\nfeatures  {}\nlibm      {}\n", from.commit,
               from.compiler, from.flags, from.cpu, from.cpu_features, from.libm);
    fmt::print("disk      {:.1f} GiB free for {}\ntruth     {}\n\n", free_GiB, options.out_dir,
               truth_here ? place.truth_worker : "missing: " + place.truth_worker);
    for (const auto& worker : workers) fmt::print("{}\n", worker_line(worker));
  }
  const bool broken = std::any_of(workers.begin(), workers.end(), [](const Worker& w) {
    return w.status != Status::ok && w.status != Status::not_built;
  });
  return broken || !truth_here ? exit_cell : exit_pass;
}

int command_schema(const Place&, const Options& options) {
  if (options.input.empty() || options.input == "scenario") {
    fmt::print("{}\n", scenario_schema());
    return exit_pass;
  }
  if (options.input != "rows") throw InputError(fmt::format("schema {}: expected scenario or rows", options.input));
  const json text = {{"type", "string"}};
  const json number_or_empty = {{"type", json::array({"number", "string", "null"})}};
  json properties = json::object();
  for (const char* name : {"scenario", "method"}) properties[name] = text;
  properties["steps"] = {{"type", "integer"}, {"description", "0 for figures of a whole ladder"}};
  properties["h_s"] = {{"type", "number"}, {"description", "t_end_s / steps"}};
  properties["body"] = text;
  properties["t_s"] = number_or_empty;
  for (const char* name : {"metric", "unit"}) properties[name] = text;
  properties["value"] = {{"type", json::array({"number", "string"})}, {"description", "a string when not finite"}};
  properties["truth_bar"] = {
      {"type", json::array({"number", "string"})},
      {"description", "the truth's half-width; of an order or exponent: half of its 95 % interval"}};
  properties["status"] = {{"enum", {"ok", "unsupported", "diverged", "not finite", "timeout", "crashed", "not built"}}};
  for (const char* name :
       {"reason", "settings_hash", "engine_version", "commit", "compiler", "flags", "cpu", "run_id"}) {
    properties[name] = text;
  }
  json required = json::array();
  for (const auto& [name, value] : properties.items()) required.push_back(name);
  const json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                       {"title", "A row of results"},
                       {"type", "object"},
                       {"required", required},
                       {"properties", properties}};
  fmt::print("{}\n", schema.dump(2));
  return exit_pass;
}

}  // namespace atwood
