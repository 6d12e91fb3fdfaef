// list, describe, doctor, schema: what is here, without running anything.
#include <sys/statvfs.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/program.hpp"
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
  return {{"id", info.id}, {"doc", info.doc}, {"source", info.source}, {"claimed_order", info.claimed_order},
          {"adaptive", info.adaptive}, {"settings", settings}};
}

// Word-wraps `text` with every line indented.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  std::string out, line;
  for (std::size_t i = 0; i < text.size();) {
    const auto end = std::min(text.find(' ', i), text.size());
    const auto word = text.substr(i, end - i);
    if (!line.empty() && indent + line.size() + 1 + word.size() > width) {
      out += std::string(indent, ' ') + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    i = end + 1;
  }
  return line.empty() ? out : out + std::string(indent, ' ') + line + "\n";
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
  if (!what.empty() && what != "scenarios" && what != "methods" && what != "metrics" && what != "gates") {
    throw InputError(fmt::format("list {}: expected scenarios, methods, metrics or gates", what));
  }
  if (options.json) {
    fmt::print("{}\n", list_json(place, options, what).dump(2));
    return exit_pass;
  }
  if (what.empty() || what == "scenarios") {
    for (const auto& s : read_catalogue(place)) fmt::print("{:<28} {}  [{}]\n", s.id, s.title, join(s.tags, " "));
  }
  if (what.empty()) fmt::print("\n");
  if (what.empty() || what == "methods") print_methods(place, options);
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

int command_describe(const Place& place, const Options& options) {
  if (names_method(options.input)) return describe_method(place, options);
  if (options.evidence)
    throw InputError(fmt::format("--program is about a library's method, as in arkode/erkstep/VERNER_8_5_6; found `{}`",
                                 options.input));
  const Scenario scenario = read_scene_argument(place, options.input);
  if (options.json) {
    fmt::print("{}\n", scenario_to_json(scenario));
    return exit_pass;
  }
  fmt::print("{}: {}\n  claim:   {}\n  source:  {}\n  tags:    {}\n", scenario.id, scenario.title, scenario.claim,
             scenario.source, join(scenario.tags, " "));
  fmt::print("  run:     {} s, {} samples, steps {}\n\n", format_double(scenario.t_end_s), scenario.samples,
             fmt::join(scenario.steps, " "));
  fmt::print("{}\n", json::parse(scene_to_json(scenario.scene)).dump(2));
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
    fmt::print("{}: {} damaged; `atwood run` measures damaged cells again; where the database itself is damaged, move "
               "the file away\n",
               path, damage.size() == 1 ? "1 thing is" : fmt::format("{} things are", damage.size()));
  }
  return damage.empty() ? exit_pass : exit_internal;
}

}  // namespace

int command_doctor(const Place& place, const Options& options) {
  if (options.check_store) return check_store_of(options);
  const auto workers = require_workers(place, options);
  struct statvfs disk{};
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
