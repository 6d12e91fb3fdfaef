#include "fluid_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include <fmt/format.h>

#include "text.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace {

using Key = std::tuple<std::string, std::string, double, double>;  // scenario, method, spacing, sound speed

struct Finest {
  std::int64_t steps = 0;
  std::map<std::string, const Row*> figures;
};

std::string value_words(const Finest& cell, const char* metric) {
  const auto found = cell.figures.find(metric);
  if (found == cell.figures.end()) return "-";
  return format_measure(found->second->value, found->second->truth_bar, 2);
}

// Where the particles' own equations were not solved, the error of the steps is part of `space`.
std::string time_words_of(const Finest& cell) {
  const auto space = cell.figures.find("space-error");
  const bool within = space != cell.figures.end() && !cell.figures.contains("time-error") &&
                      space->second->reason.find(kWithStepsError) != std::string::npos;
  return within ? "in space" : value_words(cell, "time-error");
}

// The orders of a scenario and method that belong to this spacing or sound speed: "space 4.02, time 3.99".
std::string order_words(const std::vector<const Row*>& orders, double spacing, double speed) {
  std::string words;
  for (const Row* row : orders) {
    if ((row->spacing_m && *row->spacing_m != spacing) ||
        (row->sound_speed_m_per_s && *row->sound_speed_m_per_s != speed))
      continue;
    words += (words.empty() ? "" : ", ") + row->metric.substr(6) +
             (std::isnan(row->value) ? " ?" : fmt::format(" {:.2f}", row->value));
  }
  return words.empty() ? "-" : words;
}

std::string kept_words(const Finest& cell) {
  std::string words;
  for (const auto& [metric, name] :
       std::array<std::pair<const char*, const char*>, 3>{{{"fluid-momentum-error", "momentum"},
                                                           {"fluid-angular-momentum-error", "angular"},
                                                           {"energy-budget", "energy"}}})
    if (cell.figures.contains(metric))
      words += (words.empty() ? "" : ", ") + std::string(name) + " " + value_words(cell, metric);
  return words.empty() ? "-" : words;
}

constexpr std::array<const char*, 11> kHeads{"scenario", "method", "spacing m", "c m/s",  "steps",   "total",
                                             "model",    "space",  "time",      "orders", "not kept"};
std::array<std::string, 11> cells_of(const FluidLine& l) {
  return {l.scenario, l.method, l.spacing, l.sound_speed, l.steps, l.total, l.model, l.space, l.time, l.orders, l.kept};
}
constexpr const char* kLegend =
    "Errors of the velocity (l1 norm, over that of the exact field) at the finest steps. As signed differences total = "
    "model + space + time: model is the error of the Mach number, space that of the particles, time that of the steps. `in "
    "space`: the error of the steps was not measured apart and is part of space. Scenes whose parts were all measured "
    "stand first. Orders are observed ones; `?` is an "
    "inconclusive one. Not kept: relative changes of momenta and energy.";

constexpr const char* kParts[] = {"model-error", "space-error", "time-error"};
bool in_all_parts(const Finest& cell) {
  return std::all_of(std::begin(kParts), std::end(kParts),
                     [&](const char* part) { return cell.figures.contains(part); });
}

// The most accurate line that separates the losses, in words; empty: none does.
std::string losses(const std::vector<FluidLine>& lines) {
  const FluidLine* best = nullptr;
  const auto total = [](const FluidLine& line) { return std::strtod(line.total.c_str(), nullptr); };
  for (const FluidLine& line : lines)
    if (line.in_parts && total(line) > 0 && (best == nullptr || total(line) < total(*best))) best = &line;
  if (best == nullptr) return "";
  return fmt::format(
      " What is lost to what, for example in {} by {} at a spacing of {} m and c = {} m/s: of the error of {}, the Mach "
      "number makes {}, space {} and time {}; parts of opposite signs cancel.",
      best->scenario, best->method, best->spacing, best->sound_speed, best->total, best->model, best->space,
      best->time);
}

}  // namespace

std::vector<FluidLine> fluid_lines(const std::vector<Row>& rows) {
  std::map<Key, Finest> cells;
  std::vector<Key> order;
  std::map<std::pair<std::string, std::string>, std::vector<const Row*>> orders;
  for (const Row& row : rows) {
    if (!row.spacing_m && !row.sound_speed_m_per_s) continue;
    if (row.status != Status::ok || !row.body.empty() || row.t_s) continue;
    if (row.steps == 0) {
      if (row.metric.starts_with("order-")) orders[{row.scenario, row.method}].push_back(&row);
      continue;
    }
    const Key key{row.scenario, row.method, row.spacing_m.value_or(0), row.sound_speed_m_per_s.value_or(0)};
    const auto [place, fresh] = cells.try_emplace(key);
    if (fresh) order.push_back(key);
    if (row.steps < place->second.steps) continue;
    if (row.steps > place->second.steps) place->second = {row.steps, {}};
    place->second.figures[row.metric] = &row;
  }
  // A scene with a line in parts before those without; else the order of the rows.
  std::set<std::string> whole;
  for (const Key& key : order)
    if (in_all_parts(cells[key])) whole.insert(std::get<0>(key));
  std::stable_partition(order.begin(), order.end(), [&](const Key& key) { return whole.contains(std::get<0>(key)); });
  std::vector<FluidLine> lines;
  for (const Key& key : order) {
    const Finest& cell = cells[key];
    const auto& [scenario, method, spacing, speed] = key;
    lines.push_back({scenario, method, fmt::format("{:.4g}", spacing), fmt::format("{:.4g}", speed),
                     std::to_string(cell.steps), value_words(cell, "velocity-l1"), value_words(cell, "model-error"),
                     value_words(cell, "space-error"), time_words_of(cell),
                     order_words(orders[{scenario, method}], spacing, speed), kept_words(cell), in_all_parts(cell)});
  }
  return lines;
}

std::string fluid_text(const std::vector<Row>& rows) {
  const std::vector<FluidLine> lines = fluid_lines(rows);
  if (lines.empty()) return "";
  std::array<std::size_t, 11> widths{};
  for (std::size_t i = 0; i < kHeads.size(); ++i) widths[i] = std::string_view(kHeads[i]).size();
  for (const FluidLine& line : lines) {
    const auto cells = cells_of(line);
    for (std::size_t i = 0; i < cells.size(); ++i) widths[i] = std::max(widths[i], display_width(one_line(cells[i])));
  }
  std::string out = "fluids\n";
  const auto print = [&](const std::array<std::string, 11>& cells) {
    for (std::size_t i = 1; i < cells.size(); ++i) {
      const std::string cell = one_line(cells[i]);
      const bool number = i >= 2 && i <= 8;
      out += "  " + (number                  ? std::string(widths[i] - display_width(cell), ' ') + cell
                     : i + 1 == cells.size() ? cell
                                             : cell + std::string(widths[i] - display_width(cell), ' '));
    }
    out += "\n";
  };
  std::string scenario;
  for (const FluidLine& line : lines) {
    if (line.scenario != scenario) {
      scenario = line.scenario;
      out += one_line(scenario) + "\n";
      std::array<std::string, 11> heads;
      for (std::size_t i = 0; i < heads.size(); ++i) heads[i] = kHeads[i];
      print(heads);
    }
    print(cells_of(line));
  }
  return out + "  " + kLegend + losses(lines) + "\n";
}

std::string fluid_markdown(const std::vector<Row>& rows) {
  const std::vector<FluidLine> lines = fluid_lines(rows);
  if (lines.empty()) return "";
  std::string out = "## Fluids\n\n" + std::string(kLegend) + escape_markdown_cell(losses(lines)) + "\n\n|", rule = "|";
  for (std::size_t i = 0; i < kHeads.size(); ++i) {
    out += fmt::format(" {} |", kHeads[i]);
    rule += i >= 2 && i <= 8 ? " ---: |" : " --- |";
  }
  out += "\n" + rule + "\n";
  for (const FluidLine& line : lines) {
    out += "|";
    for (const std::string& cell : cells_of(line)) out += " " + escape_markdown_cell(cell) + " |";
    out += "\n";
  }
  return out + "\n";
}

std::string fluid_html(const std::vector<Row>& rows) {
  const std::vector<FluidLine> lines = fluid_lines(rows);
  if (lines.empty()) return "";
  std::string out =
      "<div class=\"page\"><section id=\"fluids\"><h2>Fluids</h2><p class=\"hint\">" +
      escape_html(kLegend + losses(lines)) +
      "</p><div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Fluids\"><table class=\"fluids\"><thead><tr>";
  for (const char* head : kHeads) out += fmt::format("<th>{}</th>", head);
  out += "</tr></thead><tbody>";
  for (const FluidLine& line : lines) {
    out += "<tr>";
    const auto cells = cells_of(line);
    for (std::size_t i = 0; i < cells.size(); ++i)  // the heading again, for narrow screens
      out += fmt::format("<td data-head=\"{}\">{}</td>", kHeads[i], escape_html(one_line(cells[i])));
    out += "</tr>";
  }
  return out + "</tbody></table></div></section></div>\n";
}

}  // namespace atwood
