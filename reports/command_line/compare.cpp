// compare: methods side by side on each scenario: error, order, cost.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"

namespace atwood {

namespace {

using Key = std::tuple<std::string, std::string, std::int64_t, std::string>;

std::map<Key, const Row*> index_rows(const std::vector<Row>& rows) {
  std::map<Key, const Row*> index;
  for (const auto& row : rows) {
    if (row.body.empty() && !row.t_s) index[{row.scenario, row.method, row.steps, row.metric}] = &row;
  }
  return index;
}

std::string shown(const std::map<Key, const Row*>& index, const Cell& cell, const std::string& metric) {
  const auto found = index.find({cell.scenario.id, cell.method, cell.plan.steps, metric});
  if (found == index.end() || !std::isfinite(found->second->value)) return "-";
  return format_measure(found->second->value, found->second->truth_bar, 3);
}

std::string nanoseconds(const std::map<Key, const Row*>& index, const Cell& cell) {
  const auto found = index.find({cell.scenario.id, cell.method, cell.plan.steps, "step-time"});
  return found == index.end() ? "-" : fmt::format("{:.1f}", found->second->value * 1e9);
}

std::string order_of(const std::map<Key, const Row*>& index, const Cell& cell, const std::string& metric) {
  const auto found = index.find({cell.scenario.id, cell.method, 0, metric});
  if (found == index.end() || !std::isfinite(found->second->value)) return "-";
  return fmt::format("{:.2f} +/- {:.2f}", found->second->value, found->second->truth_bar);
}

struct Best { std::string method; double seconds = std::numeric_limits<double>::infinity(); std::int64_t steps = 0; };

// For each decade of error: who reaches it in least time.
void print_cheapest(const std::map<Key, const Row*>& index, const std::vector<const Cell*>& cells) {
  fmt::print("\n  cheapest for a wanted error (position, largest over the run)\n");
  for (int decade = -2; decade >= -14; decade -= 2) {
    Best best;
    for (const Cell* cell : cells) {
      const auto error = index.find({cell->scenario.id, cell->method, cell->plan.steps, "error-position-max"});
      const auto time = index.find({cell->scenario.id, cell->method, cell->plan.steps, "run-time"});
      if (error == index.end() || time == index.end()) continue;
      if (error->second->value + error->second->truth_bar <= std::pow(10.0, decade) && time->second->value < best.seconds) {
        best = {cell->method, time->second->value, cell->plan.steps};
      }
    }
    if (std::isfinite(best.seconds)) {
      fmt::print("    1e{:<4} {:<32} {:>10.1f} us  ({} steps)\n", decade, best.method, best.seconds * 1e6, best.steps);
    }
  }
}

void print_scenario(const std::map<Key, const Row*>& index, const std::vector<const Cell*>& cells) {
  const Scenario& scenario = cells.front()->scenario;
  const bool turns = std::any_of(scenario.scene.bodies.begin(), scenario.scene.bodies.end(), [](const Body& b) { return rotates(b); });
  fmt::print("{}: {}\n", scenario.id, scenario.title);
  fmt::print("  {:<32} {:>8} {:>22} {:>22} {:>12}\n", "method", "steps", "position max [m]", turns ? "attitude max [rad]" : "velocity max [m/s]",
             "ns a step");
  std::string method;
  for (const Cell* cell : cells) {
    const auto status = index.find({scenario.id, cell->method, cell->plan.steps, "status"});
    const bool failed = status != index.end() && status->second->status != Status::ok;
    if (failed) {
      fmt::print("  {:<32} {:>8} {}: {}\n", cell->method, cell->plan.steps, to_string(status->second->status), status->second->reason);
    } else {
      fmt::print("  {:<32} {:>8} {:>22} {:>22} {:>12}\n", cell->method, cell->plan.steps, shown(index, *cell, "error-position-max"),
                 shown(index, *cell, turns ? "error-attitude-max" : "error-velocity-max"), nanoseconds(index, *cell));
    }
  }
  fmt::print("\n  observed order (position{})\n", turns ? "; attitude" : "");
  for (const Cell* cell : cells) {
    if (cell->method == method) continue;
    method = cell->method;
    fmt::print("    {:<32} {}{}{}\n", method, order_of(index, *cell, "order-position"), turns ? ";  " : "",
               turns ? order_of(index, *cell, "order-attitude") : "");
  }
  print_cheapest(index, cells);
  fmt::print("\n");
}

}  // namespace

int command_compare(const Place& place, const Options& options) {
  Options chosen = options;
  if (chosen.scenarios.empty()) chosen.scenarios = {"kepler-e0.6"};
  const Selection selection = select_cells(place, chosen);
  std::error_code error;
  std::filesystem::create_directories(options.out_dir, error);
  if (error) throw std::runtime_error(fmt::format("{}: cannot make this folder: {}", options.out_dir, error.message()));
  const StudyOptions how = study_options(place, options);
  const StudyResult result = run_study(selection.cells, selection.workers, how);
  if (result.interrupted) return 128 + result.signal;
  if (options.json) {
    ReportData data;
    data.title = "compare";
    data.command = options.program;
    data.provenance = place.provenance;
    data.scenarios = selection.scenarios;
    data.rows = result.rows;
    fmt::print("{}\n", render_json(data));
  } else {
    const auto index = index_rows(result.rows);
    for (const auto& scenario : selection.scenarios) {
      std::vector<const Cell*> cells;
      for (const auto& cell : selection.cells) {
        if (cell.scenario.id == scenario.id) cells.push_back(&cell);
      }
      print_scenario(index, cells);
    }
  }
  return result.failed_cells > 0 ? exit_cell : exit_pass;
}

}  // namespace atwood
