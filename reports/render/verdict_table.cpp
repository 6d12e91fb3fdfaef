// What the terminal shows: every gate that did not pass, with its command; then a line a scenario; then the counts.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "figures_table.hpp"
#include "palette.hpp"
#include "protocol/sample.hpp"
#include "reports/report.hpp"
#include "text.hpp"

namespace atwood {
namespace {

const char* colour_of(Judgement judgement, const Palette& palette) {
  switch (judgement) {
    case Judgement::pass: return palette.green;
    case Judgement::fail: return palette.red;
    case Judgement::unverifiable:
    case Judgement::not_run: return palette.yellow;
  }
  return "";
}

// A long sentence over several lines, each indented.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  const std::size_t line_width = std::max<std::size_t>(width > indent ? width - indent : 1, 8);
  std::string out, line;
  const auto flush = [&] {
    if (!line.empty()) out += std::string(indent, ' ') + line + '\n';
    line.clear();
  };
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::size_t space = std::min(rest.find(' '), rest.size());
    std::string word(rest.substr(0, space));
    rest.remove_prefix(std::min(space + 1, rest.size()));
    if (!line.empty() && display_width(line) + 1 + display_width(word) > line_width) flush();
    line += (line.empty() ? "" : " ") + word;
    if (display_width(line) > line_width) line = fit(line, line_width);
  }
  flush();
  return out;
}

std::string failing_gate(const Verdict& verdict, const Palette& palette, std::size_t width) {
  constexpr std::size_t word = 12;  // "unverifiable"
  const std::string steps = verdict.steps > 0 ? fmt::format(" at {} steps", verdict.steps) : "";
  const std::string what = one_line(verdict.scenario + "  " + verdict.method + "  " + verdict.metric + steps);
  std::string out = colour_of(verdict.judgement, palette) + padded(to_string(verdict.judgement), word) +
                    std::string(palette.off) + "  " + fit(what, width > word + 2 ? width - word - 2 : 1) + '\n';
  out += wrapped(one_line(verdict.text), word + 2, width);
  // The command is never truncated, so that it can be copied.
  if (!verdict.rerun.empty()) {
    out += std::string(word + 2, ' ') + palette.dim + shell_line(verdict.rerun) + palette.off + '\n';
  }
  return out;
}

// A cell: scenario, method, steps; of fluids the spacing and the sound speed too.
using CellKey = std::tuple<std::string, std::string, std::int64_t, std::optional<double>, std::optional<double>>;
CellKey cell_of(const Row& row) {
  return {row.scenario, row.method, row.steps, row.spacing_m, row.sound_speed_m_per_s};
}

struct Line {
  JudgementCounts gates;
  std::int64_t cells = 0, not_ok = 0;
};
struct ScenarioLines {
  std::vector<std::string> order;
  std::map<std::string, Line> lines;
};

ScenarioLines lines_of(const std::vector<Verdict>& verdicts, const std::vector<Row>& rows) {
  ScenarioLines result;
  const auto line = [&](const std::string& scenario) -> Line& {
    const auto [where, is_new] = result.lines.try_emplace(scenario);
    if (is_new) result.order.push_back(scenario);
    return where->second;
  };
  std::set<CellKey> cells, bad;
  for (const Row& row : rows) {
    if (row.steps == 0 || row.metric == "truth") continue;  // a figure of a whole ladder is not a cell, nor is a truth
    const CellKey cell = cell_of(row);
    Line& where = line(row.scenario);
    if (cells.insert(cell).second) ++where.cells;
    if (row.status != Status::ok && bad.insert(cell).second) ++where.not_ok;
  }
  for (const Verdict& verdict : verdicts) {
    JudgementCounts& gates = line(verdict.scenario).gates;
    switch (verdict.judgement) {
      case Judgement::pass: ++gates.pass; break;
      case Judgement::fail: ++gates.fail; break;
      case Judgement::unverifiable: ++gates.unverifiable; break;
      case Judgement::not_run: ++gates.not_run; break;
    }
  }
  return result;
}

std::string status_words(const std::vector<Row>& rows) {
  std::map<Status, std::set<CellKey>> cells;
  std::set<CellKey> all;
  for (const Row& row : rows) {
    if (row.steps == 0 || row.metric == "truth") continue;
    const CellKey cell = cell_of(row);
    all.insert(cell);
    if (row.status != Status::ok) cells[row.status].insert(cell);
  }
  std::string text = fmt::format("{} {}", all.size(), all.size() == 1 ? "cell" : "cells");
  const char* separator = ": ";
  for (const auto& [status, group] : cells) {
    text += fmt::format("{}{} {}", separator, group.size(), to_string(status));
    separator = ", ";
  }
  return text;
}

// What changed against a baseline has a table of its own above.
std::string failing_gates(const std::vector<Verdict>& verdicts, const Palette& palette, std::size_t line_width,
                          bool with_baseline = false) {
  std::string out;
  for (const Verdict* verdict : failing_first(verdicts)) {
    if (verdict->judgement == Judgement::pass || (verdict->of_baseline && !with_baseline)) continue;
    out += failing_gate(*verdict, palette, line_width);
  }
  return out;
}

// A line a scenario: its gates and its cells, counted.
std::string scenario_table(const std::vector<Verdict>& verdicts, const std::vector<Row>& rows, const Palette& palette,
                           std::size_t line_width) {
  const ScenarioLines table = lines_of(verdicts, rows);
  constexpr std::array<const char*, 6> heads{"pass", "fail", "unver.", "not run", "cells", "not ok"};
  std::size_t name_width = 8;
  for (const std::string& scenario : table.order) name_width = std::max(name_width, display_width(one_line(scenario)));
  std::size_t columns_width = 0;
  for (const char* head : heads) columns_width += 2 + std::string_view(head).size();
  name_width = std::min(name_width, line_width > columns_width + 8 ? line_width - columns_width : 8);
  const auto cell = [&](std::int64_t number, std::size_t column, const char* colour) {
    const std::string text = right(number == 0 ? "." : std::to_string(number), std::string_view(heads[column]).size());
    return "  " + (number == 0 ? palette.dim + text : colour + text) + palette.off;
  };
  std::string out = palette.bold + padded("scenario", name_width);
  for (const char* head : heads) out += std::string("  ") + head;
  out += std::string(palette.off) + '\n';
  for (const std::string& scenario : table.order) {
    const Line& line = table.lines.at(scenario);
    out += padded(fit(one_line(scenario), name_width), name_width) + cell(line.gates.pass, 0, palette.green) +
           cell(line.gates.fail, 1, palette.red) + cell(line.gates.unverifiable, 2, palette.yellow) +
           cell(line.gates.not_run, 3, palette.yellow) + cell(line.cells, 4, "") +
           cell(line.not_ok, 5, palette.yellow) + '\n';
  }
  return out;
}

std::string verdict_line(const std::vector<Verdict>& verdicts, const Palette& palette) {
  const JudgementCounts counts = count(verdicts);
  const bool all_pass = counts.pass == static_cast<std::int64_t>(verdicts.size()) && !verdicts.empty();
  const char* verdict_word = verdicts.empty() ? "NO GATES" : all_pass ? "PASS" : "FAIL";
  const char* colour = verdicts.empty() ? palette.yellow : all_pass ? palette.green : palette.red;
  return fmt::format("{}{}{}{}  {}\n", palette.bold, colour, verdict_word, palette.off, words(counts));
}

std::size_t line_width_of(int width) { return static_cast<std::size_t>(width > 0 ? std::clamp(width, 60, 160) : 100); }

// What truths and claims have to say, in sentences.
std::string sentences(const ReportData& data, const Palette& palette, std::size_t line_width) {
  std::string out;
  for (const RefusedTruth& refused : data.refused_truths)
    out += palette.yellow + std::string("no truth") + palette.off + '\n' +
           wrapped(one_line(refused_words(refused)), 2, line_width);
  for (const ClaimedOrder& order : data.claimed_orders) {
    if (!order.foreign || claim_words(order).empty()) continue;
    out += wrapped(
        one_line(fmt::format("{}  {}  {}: {}.", order.scenario, order.method, order.metric, claim_words(order))), 0,
        line_width);
  }
  for (const std::string& note : data.notes) out += wrapped(one_line(note), 0, line_width);
  return out;
}

}  // namespace

std::string refused_words(const RefusedTruth& refused) {
  const char* const lost = refused.has_errors
                               ? "The error of the steps is not told apart, and is within that of space; the errors "
                                 "against the exact field are measured."
                               : "Errors, orders and what else needs a truth are not measured.";
  return fmt::format("{}: its truth ({}){} ended as {}: {}. {}{}", refused.scenario, refused.truth,
                     refused.method.empty() ? "" : " for " + refused.method, to_string(refused.status), refused.reason,
                     lost, refused.remedy.empty() ? "" : " " + refused.remedy);
}

std::string render_verdict_table(const std::vector<Verdict>& verdicts, const std::vector<Row>& rows, bool colour,
                                 int width) {
  const Palette& palette = colour ? kColours : kPlain;
  const std::size_t line_width = line_width_of(width);
  std::string out = failing_gates(verdicts, palette, line_width);
  if (!out.empty()) out += '\n';
  return out + scenario_table(verdicts, rows, palette, line_width) + "\n" + status_words(rows) + '\n' +
         verdict_line(verdicts, palette);
}

std::string render_run_table(const ReportData& data, bool colour, int width) {
  const Palette& palette = colour ? kColours : kPlain;
  const std::size_t line_width = line_width_of(width);
  const std::string failing = failing_gates(data.verdicts, palette, line_width);
  std::string out;
  if (const std::string figures = figures_table(data, palette, line_width); !figures.empty())
    out = figures + (failing.empty() ? "" : "\n") + failing;
  else out = failing + (failing.empty() ? "" : "\n") + scenario_table(data.verdicts, data.rows, palette, line_width);
  if (const std::string said = sentences(data, palette, line_width); !said.empty()) out += "\n" + said;
  return out + "\n" + status_words(data.rows) + '\n' + verdict_line(data.verdicts, palette);
}

std::string render_quiet(const ReportData& data, const std::string& tail) {
  std::string line = verdict_line(data.verdicts, kPlain);
  line.pop_back();
  std::string out = failing_gates(data.verdicts, kPlain, 100, true);
  for (const RefusedTruth& refused : data.refused_truths)
    out += "no truth      " + one_line(refused_words(refused)) + "\n";
  return out + line + "; " + tail + "\n";
}

}  // namespace atwood
