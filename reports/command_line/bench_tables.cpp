// Tables of figures that are no benchmark of Google's: kept in bench.json, shown by every report after.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "scene/files.hpp"
#include "scene/input_file.hpp"

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

}  // namespace

std::string read_bench_text(const std::string& path) {
  if (!fs::exists(path)) return "";
  const std::string text = read_input_file(path, "figures of `atwood bench` (JSON)", largest::kFigures);
  require_shallow_json(text, path);
  return text;
}

std::vector<BenchTable> read_bench_tables(const std::string& path) { return tables_from(read_document(path)); }

void keep_bench_table(const std::string& path, const Provenance& provenance, const BenchTable& table) {
  json document = read_document(path);
  document.update({{"commit", provenance.commit},
                   {"compiler", provenance.compiler},
                   {"flags", provenance.flags},
                   {"cpu", provenance.cpu}});
  json kept = json::array();
  for (const BenchTable& old : tables_from(document)) {
    if (old.id != table.id) kept.push_back(to_json(old));
  }
  kept.push_back(to_json(table));
  document["tables"] = kept;
  std::error_code error;
  fs::create_directories(fs::path(path).parent_path(), error);
  write_file(path, document.dump(1) + "\n");
}

void show_bench_tables(const Place& place, const Options& options, const std::vector<BenchTable>& tables) {
  json all = json::array();
  for (const BenchTable& table : tables) {
    keep_bench_table(options.out_dir + "/bench.json", place.provenance, table);
    if (options.json) all.push_back(to_json(table));
    else fmt::print("{}\n", render_bench_table(table));
  }
  if (options.json) fmt::print("{}\n", json{{"tables", all}}.dump(1));
  else fmt::print("{}/bench.json; `atwood report` shows them\n", options.out_dir);
}

std::vector<BenchTable> measure_broad_phases(const Place& place) {
  const std::string program = place.bin_dir + "/atwood-broad-phases";
  if (!fs::exists(program)) throw InputError("the comparison of broad phases is not built; `./atwood bench` builds it");
  return tables_from(json::parse(capture({program})));
}

int command_broad_phases(const Place& place, const Options& options) {
  show_bench_tables(place, options, measure_broad_phases(place));
  return exit_pass;
}

}  // namespace atwood
