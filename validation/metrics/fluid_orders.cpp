// Orders of a fluid's errors along its three ladders, from rows alone.
#include <algorithm>
#include <cmath>
#include <map>

#include "scene/files.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

struct FluidRung {
  double h = 0, error = 0, floor = 0;
  std::int64_t steps = 0;
};

std::string short_number(double x) { return format_measure(x, 0, 4); }

// `rungs`: by h, the coarsest last in the map; `what`: the unit of h in words.
Row order_row(const std::string& metric, const std::map<double, FluidRung>& rungs, const Row& like, const char* what,
              bool inverse) {
  std::vector<double> h, error, floor;
  for (auto at = rungs.rbegin(); at != rungs.rend(); ++at) {
    h.push_back(at->second.h), error.push_back(at->second.error), floor.push_back(at->second.floor);
  }
  const OrderFit fit = fit_order(h, error, floor);
  const auto words = [&](double x) { return short_number(inverse ? 1 / x : x); };
  std::string text = "inconclusive: " + fit.reason;
  if (fit.conclusive)
    text = words(h[static_cast<std::size_t>(fit.used.front())]) + " to " +
           words(h[static_cast<std::size_t>(fit.used.back())]) + " " + what + ", " + std::to_string(fit.used.size()) +
           " rungs, +/- " + format_measure(fit.half_width_95, 0, 2) + ", finest slope " +
           format_measure(fit.finest_slope, 0, 4) + ", extrapolated " + format_measure(fit.extrapolated, 0, 4);
  std::string left_out;
  for (std::size_t i = 0; i < fit.left_out.size(); ++i)
    if (!fit.left_out[i].empty())
      left_out += (left_out.empty() ? "" : ", ") + words(h[i]) + " (" + fit.left_out[i] + ")";
  if (!left_out.empty()) text += "; left out: " + left_out;
  Row row =
      metrics::row(metric, fit.conclusive ? fit.order : std::nan(""), fit.conclusive ? fit.half_width_95 : 0, text);
  row.scenario = like.scenario;
  row.method = like.method;
  row.settings_hash = like.settings_hash;
  row.provenance = like.provenance;
  return row;
}

bool of_run(const Row& row, const char* metric) {
  return row.metric == metric && row.body.empty() && !row.t_s && row.status == Status::ok && row.steps > 0 &&
         row.spacing_m && row.sound_speed_m_per_s;
}

}  // namespace

std::vector<Row> fit_fluid_orders(std::span<const Row> cells) {
  std::vector<Row> rows;
  struct Ladder {
    std::map<double, FluidRung> rungs;  // by h
    const Row* like = nullptr;
  };
  std::map<double, Ladder> space, model;             // by sound speed, by spacing
  std::map<std::pair<double, double>, Ladder> time;  // by both
  const auto take = [](Ladder& ladder, double h, const Row& row) {
    FluidRung& rung = ladder.rungs[h];
    if (rung.steps > row.steps) return;  // the finest steps of this rung
    rung = {h, std::fabs(row.value), row.truth_bar, row.steps};
    ladder.like = &row;
  };
  for (const Row& row : cells) {
    if (of_run(row, "space-error")) take(space[*row.sound_speed_m_per_s], *row.spacing_m, row);
    if (of_run(row, "model-error")) take(model[*row.spacing_m], 1 / *row.sound_speed_m_per_s, row);
    if (of_run(row, "time-error") && row.method.find(':') == std::string::npos)
      take(time[{*row.spacing_m, *row.sound_speed_m_per_s}], row.h_s, row);
  }
  for (const auto& [speed, ladder] : space) {
    if (ladder.rungs.size() < 2) continue;
    rows.push_back(order_row("order-space", ladder.rungs, *ladder.like, "m", false));
    rows.back().sound_speed_m_per_s = speed;
  }
  for (const auto& [at, ladder] : time) {
    if (ladder.rungs.size() < 2) continue;
    rows.push_back(order_row("order-time", ladder.rungs, *ladder.like, "s", false));
    rows.back().spacing_m = at.first, rows.back().sound_speed_m_per_s = at.second;
  }
  for (const auto& [spacing, ladder] : model) {
    if (ladder.rungs.size() < 2) continue;
    rows.push_back(order_row("order-model", ladder.rungs, *ladder.like, "m/s", true));
    rows.back().spacing_m = spacing;
  }
  return rows;
}

}  // namespace atwood
