#include "solver_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "reports/report.hpp"
#include "text.hpp"

namespace atwood {
namespace {

// Of one solver in one cell.
struct CellSolves {
  const Row* residual = nullptr;
  double converged = 0, stagnated = 0, capped = 0, iterations = 0;
};

using CellKey = std::tuple<std::string, std::string, std::int64_t, std::string>;  // scenario, method, steps, solver

std::map<CellKey, CellSolves> solves_of(const std::vector<Row>& rows) {
  std::map<CellKey, CellSolves> all;
  for (const Row& row : rows) {
    if (row.body.empty() || row.status != Status::ok || !row.metric.starts_with("solver-")) continue;
    const std::string at = resolution_text(resolution_of(row));  // of fluids
    CellSolves& cell = all[{row.scenario, row.method, row.steps, at.empty() ? row.body : row.body + " at " + at}];
    if (row.metric == "solver-residual-max") cell.residual = &row;
    else if (row.metric == "solver-converged") cell.converged = row.value;
    else if (row.metric == "solver-stagnated") cell.stagnated = row.value;
    else if (row.metric == "solver-capped") cell.capped = row.value;
    else if (row.metric == "solver-iterations-max") cell.iterations = row.value;
  }
  return all;
}

// NaN is larger than any number.
bool larger(const CellSolves& a, const CellSolves& b) {
  const double x = a.residual->value, y = b.residual->value;
  return std::isnan(x) != std::isnan(y) ? std::isnan(x) : x > y;
}

}  // namespace

std::string solvers_section(const std::vector<Row>& rows, std::size_t most) {
  const std::map<CellKey, CellSolves> all = solves_of(rows);
  using Line = std::pair<const CellKey*, const CellSolves*>;
  std::map<std::tuple<std::string, std::string, std::string>, Line> worst;
  for (const auto& [key, cell] : all) {
    if (!(cell.capped > 0) || cell.residual == nullptr) continue;
    const auto& [scenario, method, steps, solver] = key;
    Line& line = worst[{scenario, method, solver}];
    if (line.first == nullptr || larger(cell, *line.second)) line = {&key, &cell};
  }
  if (worst.empty()) return "";
  std::vector<Line> lines;
  for (const auto& [key, line] : worst) lines.push_back(line);
  std::stable_sort(lines.begin(), lines.end(),
                   [](const Line& a, const Line& b) { return larger(*a.second, *b.second); });
  std::string out =
      "## Solves that ended above their tolerance\n\n"
      "| scenario | method | steps | solver | capped | of | most iterations | largest residual | relative to |\n"
      "| --- | --- | ---: | --- | ---: | ---: | ---: | ---: | --- |\n";
  for (std::size_t i = 0; i < lines.size() && i < most; ++i) {
    const auto& [scenario, method, steps, solver] = *lines[i].first;
    const CellSolves& cell = *lines[i].second;
    out += fmt::format("| {} | {} | {} | {} | {:.0f} | {:.0f} | {:.0f} | {} | {} |\n", escape_markdown_cell(scenario),
                       escape_markdown_cell(method), steps > 0 ? std::to_string(steps) : "-",
                       escape_markdown_cell(solver), cell.capped, cell.capped + cell.converged + cell.stagnated,
                       cell.iterations, figure(cell.residual->value, 3), escape_markdown_cell(cell.residual->reason));
  }
  if (lines.size() > most) out += fmt::format("\nAnd {} more.\n", lines.size() - most);
  return out + "\n";
}

std::string unconverged_words(const std::vector<Row>& rows) {
  struct Sum {
    std::size_t cells = 0;
    const CellKey* key = nullptr;
    const CellSolves* worst = nullptr;
  };
  const std::map<CellKey, CellSolves> all = solves_of(rows);
  std::map<std::string, Sum> sums;
  for (const auto& [key, cell] : all) {
    if (!(cell.capped > 0) || cell.residual == nullptr) continue;
    Sum& sum = sums[std::get<3>(key)];
    ++sum.cells;
    if (sum.worst == nullptr || larger(cell, *sum.worst)) sum.worst = &cell, sum.key = &key;
  }
  std::string out;
  for (const auto& [solver, sum] : sums)
    out += fmt::format("{}: solves above the tolerance in {} cell{}, residual up to {} ({}, {}, {} steps)\n",
                       one_line(solver), sum.cells, sum.cells == 1 ? "" : "s", figure(sum.worst->residual->value, 2),
                       one_line(std::get<0>(*sum.key)), one_line(std::get<1>(*sum.key)), std::get<2>(*sum.key));
  return out;
}

}  // namespace atwood
