#include "reports/render/statistics_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "text.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace {

// In the order in which they are shown.
constexpr std::array<const char*, 13> kShown = {"growth-exponent-round-off-energy",
                                                "growth-exponent-round-off-position",
                                                "growth-exponent-round-off-attitude",
                                                "reversal-over-round-off",
                                                "symplecticity-defect",
                                                "poisson-defect",
                                                "lyapunov-exponent",
                                                "horizon",
                                                "state-differences",
                                                "state-hash",
                                                "round-off-best-error",
                                                "round-off-best-step",
                                                "tolerance-exponent"};

std::vector<const Row*> of_metric(const std::vector<Row>& rows, const std::string& metric) {
  std::vector<const Row*> found;
  for (const Row& row : rows)
    if (row.metric == metric && row.body.empty() && !row.t_s) found.push_back(&row);
  return found;
}

std::string value_words(const Row& row) {
  if (row.status != Status::ok) return to_string(row.status);
  if (std::isnan(row.value)) return "inconclusive";
  if (row.metric == "state-hash") return fmt::format("{:012x}", static_cast<std::uint64_t>(row.value));
  const bool fitted = row.metric.find("exponent") != std::string::npos;
  const std::string text = fitted ? fmt::format("{} +/- {}", figure(row.value, 3), figure(row.truth_bar, 2))
                                  : format_measure(row.value, row.truth_bar);
  return row.unit.empty() || row.unit == "1" ? text : text + " " + row.unit;
}

std::string definition_of(const std::string& metric) {
  for (const MetricInfo& info : all_metrics())
    if (info.name == metric) return info.definition;
  return "";
}

}  // namespace

std::string statistics_section(const std::vector<Row>& rows) {
  std::string table, definitions;
  for (const char* metric : kShown) {
    const auto found = of_metric(rows, metric);
    if (found.empty()) continue;
    definitions += fmt::format("- {}: {}\n", metric, escape_markdown_cell(definition_of(metric)));
    for (const Row* row : found)
      table += fmt::format("| {} | {} | {} | {} | {} | {} |\n", metric, escape_markdown_cell(row->scenario),
                           escape_markdown_cell(row->method), row->steps > 0 ? std::to_string(row->steps) : "-",
                           escape_markdown_cell(value_words(*row)), escape_markdown_cell(row->reason));
  }
  if (table.empty()) return "";
  return "## Statistics\n\n| metric | scenario | method | steps | figure | what was found |\n| --- | --- | --- | ---: "
         "| ---: | --- |\n" +
         table + "\n" + definitions + "\n";
}

}  // namespace atwood
