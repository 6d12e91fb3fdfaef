// The report of a selection's rows, and the files it is written to.
#include <filesystem>

#include <fmt/format.h>

#include "benchmarks/bench_file.hpp"
#include "reports/command_line/command_line.hpp"
#include "reports/render/wasm_table.hpp"
#include "scene/files.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMaxDrawnBodies = 60;   // of a scene's picture
constexpr std::size_t kMaxPlayedScenes = 48;  // with methods beside the truth

// Titled by what it is: a narrowed run by its scene, or by how many there are.
std::string title_of(const Options& options, const Selection& selection) {
  const std::string study = options.study.empty() ? "the default study" : selection.study;
  const bool narrowed = !options.scenarios.empty() || !options.methods.empty();
  const std::size_t count = selection.scenarios.size();
  if (!narrowed || count == 0) return "Atwood: " + study;
  const Scenario& first = selection.scenarios.front();
  if (count == 1) return "Atwood: " + (first.title.empty() ? first.id : first.title);
  return fmt::format("Atwood: {} scenes of {}", count, study);
}

}  // namespace

ReportData assemble_report(const Place& place, const Options& options, const Selection& selection,
                           const StudyResult& result, const std::vector<Verdict>& verdicts) {
  ReportData data;
  data.title = title_of(options, selection);
  data.command = options.program;
  data.program = shell_line(std::vector{options.words.front()});
  data.provenance = place.provenance;
  data.scenarios = selection.scenarios;
  for (const auto& scenario : selection.scenarios) {
    if (const std::string file = own_file(place, scenario); !file.empty()) data.own_files[scenario.id] = file;
  }
  for (const auto& worker : selection.workers) {
    if (worker.status == Status::ok) data.engines.push_back(worker.engine);
    else
      data.missing_engines.emplace_back(fs::path(worker.path).filename().string(),
                                        to_string(worker.status) + ": " + worker.reason);
  }
  data.notes = unconfined_engines(selection.workers);
  data.metrics = all_metrics();
  data.rows = result.rows;
  data.verdicts = verdicts;
  data.series = load_series(options.out_dir + "/store.db", selection.cells, options.purpose);
  data.pictures = load_pictures(options.out_dir + "/store.db", selection.cells, options.purpose);
  data.paths = load_truth_paths(options.out_dir + "/store.db", selection.cells, place.truth_worker, kMaxDrawnBodies,
                                kMaxPlayedScenes, options.purpose);
  data.laws = find_laws(data.scenarios, data.rows);
  data.bench = read_bench(options.out_dir + "/bench.json");
  data.goals = read_goal_results(options.out_dir + "/bench.json");
  data.tables = read_bench_tables(options.out_dir + "/bench.json");
  for (BenchTable& table : wasm_tables(data.rows)) data.tables.push_back(std::move(table));
  data.dominance = find_dominance(data.rows);
  if (selection.study == "audit") data.audit = audit_orders(data.engines, data.rows);
  return data;
}

void write_named_outputs(const Options& options, const ReportData& data) {
  for (const auto& output : options.outputs) {
    const auto colon = output.find(':');
    const std::string format = output.substr(0, colon);
    const std::string path = colon == std::string::npos ? "" : output.substr(colon + 1);
    if (path.empty()) throw InputError(fmt::format("-o {}: expected FORMAT:FILE", output));
    if (format == "csv") write_file(path, render_csv(data.rows));
    else if (format == "json") write_file(path, render_json(data));
    else if (format == "markdown" || format == "md") write_file(path, render_markdown(data));
    else if (format == "junit") write_file(path, render_junit(data.verdicts, data.cells));
    else if (format == "html") write_file(path, render_html(data));
    else
      throw InputError(
          fmt::format("-o {}: found format `{}`; expected csv, json, markdown, junit or html", output, format));
  }
  if (!options.junit.empty()) write_file(options.junit, render_junit(data.verdicts, data.cells));
}

}  // namespace atwood
