// bench.json: the figures, goals and tables of `atwood bench`, which reports show.
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "benchmarks/bench_file.hpp"
#include "scene/input_file.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

namespace {

std::vector<BenchTable> tables_from(const json& document) {
  std::vector<BenchTable> tables;
  if (!document.is_object() || !document.contains("tables")) return tables;
  for (const json& t : document.at("tables")) {
    BenchTable& table = tables.emplace_back();
    table.id = t.value("id", "");
    table.title = t.value("title", "");
    table.columns = t.value("columns", std::vector<std::string>{});
    table.notes = t.value("notes", std::vector<std::string>{});
    for (const json& r : t.value("rows", json::array())) {
      auto& row = table.rows.emplace_back();
      for (const json& cell : r) {
        if (cell.is_string()) row.emplace_back(cell.get<std::string>());
        else row.emplace_back(cell.is_number() ? cell.get<double>() : std::nan(""));
      }
    }
  }
  return tables;
}

json to_json(const BenchTable& table) {
  json rows = json::array();
  for (const auto& row : table.rows) {
    json cells = json::array();
    for (const TableCell& cell : row)
      std::visit([&](const auto& value) { cells.push_back(value); }, cell);  // NaN becomes null
    rows.push_back(cells);
  }
  return {{"id", table.id}, {"title", table.title}, {"columns", table.columns}, {"rows", rows}, {"notes", table.notes}};
}

json read_document(const std::string& path) {
  const std::string text = read_bench_text(path);
  json document = text.empty() ? json::object() : json::parse(text, nullptr, false);
  return document.is_object() ? document : json::object();
}

void add_provenance(json& document, const Provenance& provenance) {
  document.update({{"commit", provenance.commit},
                   {"compiler", provenance.compiler},
                   {"flags", provenance.flags},
                   {"cpu", provenance.cpu}});
}

void keep(const std::string& path, const json& document) {
  std::error_code error;
  fs::create_directories(fs::path(path).parent_path(), error);
  write_file(path, document.dump(1) + "\n");
}

double real(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nan("");
  if (*found == "inf") return std::numeric_limits<double>::infinity();
  return found->is_number() ? found->get<double>() : std::nan("");
}

json number(double value) { return std::isinf(value) ? json("inf") : json(value); }  // NaN becomes null

json to_json(const GoalEntrant& e) {
  if (e.method.empty()) return nullptr;
  return {{"method", e.method},
          {"steps", e.steps},
          {"error", e.error},
          {"bar", e.bar},
          {"seconds", e.seconds},
          {"evaluations", e.evaluations},
          {"ns_per_step", e.ns_per_step},
          {"accurate", e.accurate},
          {"last_quarter", number(e.last_quarter)},
          {"floor", e.floor}};  // NaN becomes null
}

json to_json(const std::vector<GoalEntrant>& entrants) {
  json all = json::array();
  for (const GoalEntrant& entrant : entrants) all.push_back(to_json(entrant));
  return all;
}

json to_json(const MachineState& machine) {
  return {{"timings", machine.timings}, {"interrupted", machine.interrupted}, {"repeated", machine.repeated},
          {"ghz_low", machine.ghz_low}, {"ghz_high", machine.ghz_high},       {"again", machine.again}};
}

GoalEntrant entrant_from(const json& j) {
  if (!j.is_object()) return {};
  return {j.value("method", ""),   j.value("steps", std::int64_t{0}),
          real(j, "error"),        real(j, "bar"),
          real(j, "seconds"),      real(j, "evaluations"),
          real(j, "ns_per_step"),  j.value("accurate", false),
          real(j, "last_quarter"), real(j, "floor")};
}

GoalEntrant entrant_from(const json& goal, const char* key) { return entrant_from(goal.value(key, json())); }

std::vector<GoalEntrant> entrants_from(const json& goal, const char* key) {
  std::vector<GoalEntrant> entrants;
  for (const json& entrant : goal.value(key, json::array())) entrants.push_back(entrant_from(entrant));
  return entrants;
}

MachineState machine_from(const json& goal, const char* key) {
  const json j = goal.value(key, json());
  if (!j.is_object()) return {};
  const auto count = [&](const char* name) { return j.value(name, std::int64_t{0}); };
  return {count("timings"),   count("interrupted"), count("repeated"),
          real(j, "ghz_low"), real(j, "ghz_high"),  count("again")};
}

}  // namespace

std::string read_bench_text(const std::string& path) {
  if (!fs::exists(path)) return "";
  const std::string text = read_input_file(path, "figures of `atwood bench` (JSON)", largest::kFigures);
  require_shallow_json(text, path);
  return text;
}

std::vector<BenchTable> read_bench_tables(const std::string& path) { return tables_from(read_document(path)); }

std::vector<BenchTable> bench_tables_from(const std::string& text) { return tables_from(json::parse(text)); }

std::string bench_tables_json(const std::vector<BenchTable>& tables) {
  json all = json::array();
  for (const BenchTable& table : tables) all.push_back(to_json(table));
  return json{{"tables", all}}.dump(1);
}

void keep_bench_table(const std::string& path, const Provenance& provenance, const BenchTable& table) {
  json document = read_document(path);
  add_provenance(document, provenance);
  json kept = json::array();
  for (const BenchTable& old : tables_from(document)) {
    if (old.id != table.id) kept.push_back(to_json(old));
  }
  kept.push_back(to_json(table));
  document["tables"] = kept;
  keep(path, document);
}

std::vector<BenchFigure> read_bench(const std::string& path) {
  std::vector<BenchFigure> figures;
  const json document = read_document(path);
  if (!document.contains("figures")) return figures;
  for (const auto& f : document.at("figures")) {
    const Estimate ns{real(f, "ns_median"), real(f, "ns_low"), real(f, "ns_high")};
    figures.push_back({f.value("scenario", ""), f.value("method", ""), f.value("steps", std::int64_t{0}), ns,
                       real(f, "ns_p95"), f.value("name", "")});
  }
  return figures;
}

std::vector<GoalResult> read_goal_results(const std::string& path) {
  std::vector<GoalResult> goals;
  const json document = read_document(path);
  if (!document.contains("goals")) return goals;
  for (const json& g : document["goals"]) {
    goals.push_back({g.value("id", ""),
                     g.value("title", ""),
                     g.value("scenario", ""),
                     g.value("metric", ""),
                     g.value("unit", ""),
                     real(g, "wanted_error"),
                     g.value("budget_kind", ""),
                     real(g, "budget"),
                     g.value("reached", false),
                     entrant_from(g, "ours"),
                     entrant_from(g, "rival"),
                     entrant_from(g, "uncounted"),
                     real(g, "ratio"),
                     real(g, "ratio_low"),
                     real(g, "ratio_high"),
                     g.value("why", ""),
                     g.value("wanted_ratio", 0.0),
                     entrant_from(g, "same_rate"),
                     entrant_from(g, "library"),
                     real(g, "same_rate_ratio"),
                     real(g, "same_rate_low"),
                     real(g, "same_rate_high"),
                     real(g, "low"),
                     real(g, "high"),
                     entrants_from(g, "close"),
                     machine_from(g, "machine"),
                     g.value("left_out", std::vector<std::string>{})});
  }
  return goals;
}

void keep_bench(const std::string& path, const Provenance& provenance, const std::vector<BenchFigure>* figures,
                const std::vector<GoalResult>* goals) {
  json document = read_document(path);
  add_provenance(document, provenance);
  if (figures != nullptr) {
    document["figures"] = json::array();
    for (const auto& f : *figures) {
      document["figures"].push_back({{"name", f.name},
                                     {"scenario", f.scenario},
                                     {"method", f.method},
                                     {"steps", f.steps},
                                     {"ns_median", f.ns_per_step.value},
                                     {"ns_low", f.ns_per_step.low},
                                     {"ns_high", f.ns_per_step.high},
                                     {"ns_p95", f.ns_per_step_p95}});
    }
  }
  if (goals != nullptr) {
    document["goals"] = json::array();
    for (const auto& g : *goals) {
      document["goals"].push_back({{"id", g.id},
                                   {"title", g.title},
                                   {"scenario", g.scenario},
                                   {"metric", g.metric},
                                   {"unit", g.unit},
                                   {"wanted_error", g.wanted_error},
                                   {"budget_kind", g.budget_kind},
                                   {"budget", g.budget},
                                   {"reached", g.reached},
                                   {"ours", to_json(g.ours)},
                                   {"rival", to_json(g.rival)},
                                   {"uncounted", to_json(g.uncounted)},
                                   {"ratio", g.ratio},
                                   {"ratio_low", g.ratio_low},
                                   {"ratio_high", g.ratio_high},
                                   {"why", g.why},
                                   {"wanted_ratio", g.wanted_ratio},
                                   {"same_rate", to_json(g.same_rate)},
                                   {"library", to_json(g.library)},
                                   {"same_rate_ratio", g.same_rate_ratio},
                                   {"same_rate_low", g.same_rate_low},
                                   {"same_rate_high", g.same_rate_high},
                                   {"low", g.low},
                                   {"high", g.high},
                                   {"close", to_json(g.close)},
                                   {"machine", to_json(g.machine)},
                                   {"left_out", g.left_out}});
    }
  }
  keep(path, document);
}

}  // namespace atwood
