// Rows in, documents out. Rendering runs no physics: a report can be made again from its rows.
#pragma once

#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "scene/scene.hpp"
#include "validation/gates/gates.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/row.hpp"
#include "validation/study/study.hpp"

namespace atwood {

struct BenchFigure { std::string scenario, method; std::int64_t steps; double ns_per_step_median, ns_per_step_p95; std::string name; };

// A law that predicts a measured figure, printed beside it ("range error = v_x h").
struct Law { std::string scenario, method, metric, statement; std::int64_t steps; double predicted, measured; std::string unit; };

struct ReportData {
  std::string title;
  std::string command;                 // how this report was made
  Provenance provenance;
  std::vector<Scenario> scenarios;
  std::vector<Engine> engines;         // settings of every method
  std::vector<std::pair<std::string, std::string>> missing_engines;  // name, reason
  std::vector<MetricInfo> metrics;
  std::vector<Row> rows;
  std::vector<Verdict> verdicts;
  std::vector<StoredSeries> series;
  std::vector<Law> laws;
  std::vector<BenchFigure> bench;
};

std::string render_html(const ReportData& data);      // one self-contained file
std::string render_json(const ReportData& data);
std::string render_csv(const std::vector<Row>& rows); // the contract's columns
std::string render_markdown(const ReportData& data);
std::string render_junit(const std::vector<Verdict>& verdicts);
std::string render_verdict_table(const std::vector<Verdict>& verdicts, const std::vector<Row>& rows, bool colour, int width);

// Writes to a temporary beside the target, fsyncs, renames: a full disk leaves no partial file. Throws
// std::runtime_error with the system's words.
void write_file(const std::string& path, const std::string& content);

}  // namespace atwood
