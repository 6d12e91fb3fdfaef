#include "counts_table.hpp"

#include <array>

#include <fmt/format.h>

namespace atwood {
namespace {

constexpr const char* kCountsLegend =
    "Every cell and gate of the study is counted here. The rest of this page shows some ladders of each scene: the most "
    "and the least accurate at the finest rung, and those where something did not pass. The command writes a page of that "
    "scene only, and with --method METHOD one with every row of a method.";
constexpr std::array<const char*, 9> kCountHeads{"ladders", "shown", "cells",  "not ok", "missing",
                                                 "pass",    "fail",  "unver.", "not run"};

std::array<std::size_t, 9> counts_in_columns(const SceneCounts& c) {
  return {c.ladders, c.shown, c.cells, c.not_ok, c.missing, c.pass, c.fail, c.unverifiable, c.not_run};
}

}  // namespace

JudgementCounts count(const ReportData& data) {
  if (data.counted.empty()) return count(data.verdicts);
  const auto whole = [](std::size_t n) { return static_cast<std::int64_t>(n); };
  const SceneCounts& all = data.counted_in_all;
  return {whole(all.pass), whole(all.fail), whole(all.unverifiable), whole(all.not_run)};
}

std::string counts_html(const ReportData& data) {
  if (data.counted.empty()) return "";
  std::string out = "<div class=\"page\"><section id=\"counts\"><h2>Cells and gates by scene</h2><p class=\"hint\">" +
                    escape_html(kCountsLegend) +
                    "</p><div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Cells and gates by "
                    "scene\"><table><thead><tr><th>scene</th>";
  for (const char* head : kCountHeads) out += fmt::format("<th class=\"number\">{}</th>", head);
  out += "<th>its page</th></tr></thead><tbody>";
  for (const CountedScene& one : data.counted) {
    out += "<tr><td>" + escape_html(one_line(one.scenario)) + "</td>";
    for (const std::size_t number : counts_in_columns(one.counts))
      out += fmt::format("<td class=\"number\">{}</td>", number);
    out += "<td><code>" + escape_html(one_line(one.command)) + "</code></td></tr>";
  }
  return out + "</tbody></table></div></section></div>\n";
}

std::string counts_markdown(const ReportData& data) {
  if (data.counted.empty()) return "";
  std::string out = "## Cells and gates by scene\n\n| scene |", rule = "| --- |";
  for (const char* head : kCountHeads) {
    out += fmt::format(" {} |", head);
    rule += " ---: |";
  }
  out += "\n" + rule + "\n";
  for (const CountedScene& one : data.counted) {
    out += "| " + escape_markdown_cell(one.scenario) + " |";
    for (const std::size_t number : counts_in_columns(one.counts)) out += fmt::format(" {} |", number);
    out += "\n";
  }
  return out + "\n";
}

}  // namespace atwood
