// Figures of a whole ladder, from the rows of its cells.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

struct Rung {
  double h_s = 0, error = 0, floor = 0;
  std::int64_t steps = 0;
};

double size_of(const std::map<std::string, double>& cell, const std::string& metric) {
  const auto found = cell.find(metric);
  return found == cell.end() ? 0 : found->second;
}

// The scale that round-off is relative to: coordinates for positions, one for angles (an attitude is kept to the unit
// round-off of a unit quaternion), and the truth's duration for times.
double scale(const std::string& metric, const std::map<std::string, double>& cell, double t_end_s) {
  if (metric == "error-position-end") return size_of(cell, "size-position");
  if (metric == "error-velocity-end") return size_of(cell, "size-velocity");
  if (metric == "error-body-rate-end") return size_of(cell, "size-body-rate");
  if (metric == "error-attitude-end") return 1;
  if (metric == "error-joint-coordinate-end") return std::max(1.0, size_of(cell, "size-joint-coordinate"));
  return t_end_s;
}

std::string significant(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", x);
  return text;
}

std::string window_text(const OrderFit& fit, const std::vector<Rung>& rungs) {
  std::string text;
  if (fit.conclusive) {
    text = std::to_string(rungs[fit.used.front()].steps) + ".." + std::to_string(rungs[fit.used.back()].steps) +
           " steps, " + std::to_string(fit.used.size()) + " rungs, +/- " + significant(fit.half_width_95) +
           ", finest slope " + format_measure(fit.finest_slope, 0, 4) + ", extrapolated " +
           format_measure(fit.extrapolated, 0, 4);
    if (fit.order + fit.half_width_95 < 0) text += "; negative: the error grows as h shrinks, above the floor";
  } else {
    text = "inconclusive: " + fit.reason;
  }
  std::string left_out;
  for (const std::string why : {"pre-asymptotic", "floor", "not finite"}) {
    std::string steps;
    for (std::size_t i = 0; i < rungs.size(); ++i)
      if (fit.left_out[i] == why) steps += (steps.empty() ? "" : " ") + std::to_string(rungs[i].steps);
    if (!steps.empty()) left_out += (left_out.empty() ? "" : ", ") + steps + " (" + why + ")";
  }
  return left_out.empty() ? text : text + "; left out: " + left_out;
}

Row order_row(const std::string& metric, const std::vector<Rung>& rungs, const Row& like) {
  std::vector<double> h, error, floor;
  for (const Rung& r : rungs) {
    h.push_back(r.h_s);
    error.push_back(r.error);
    floor.push_back(r.floor);
  }
  const OrderFit fit = fit_order(h, error, floor);
  Row row = metrics::row(metric, fit.conclusive ? fit.order : std::nan(""), fit.conclusive ? fit.half_width_95 : 0,
                         window_text(fit, rungs));
  row.scenario = like.scenario;
  row.method = like.method;
  row.settings_hash = like.settings_hash;
  row.provenance = like.provenance;
  return row;
}

}  // namespace

double accuracy_floor(const std::string& metric, std::span<const Row> cell) {
  if (!metric.starts_with("error-") || !metric.ends_with("-end")) return std::nan("");
  std::map<std::string, double> figures;
  for (const Row& r : cell)
    if (r.status == Status::ok && r.body.empty() && !r.t_s && (r.metric != "condition" || r.reason.empty()))
      figures[r.metric] = r.value;
  if (!figures.contains("condition")) return std::nan("");
  const double size = metric == "error-state-end" ? 1 : scale(metric, figures, std::nan(""));
  return unit_round_off(cell.front().method) * std::max(1.0, figures.at("condition")) * size;
}

std::vector<Row> fit_ladder(std::span<const Row> cells) {
  std::vector<Row> rows;
  if (cells.empty() || cells.front().method.find(':') != std::string::npos) return rows;
  const double unit = unit_round_off(cells.front().method);
  std::map<std::int64_t, std::map<std::string, double>> figures;  // steps -> metric -> value
  for (const Row& r : cells)
    if (r.status == Status::ok && r.body.empty() && !r.t_s) figures[r.steps][r.metric] = r.value;

  const std::vector<std::pair<std::string, std::string>> orders = {
      {"error-position-end", "order-position"},
      {"error-velocity-end", "order-velocity"},
      {"error-attitude-end", "order-attitude"},
      {"error-body-rate-end", "order-body-rate"},
      {"error-joint-coordinate-end", "order-joint-coordinate"},
      {"impact-time-error", "order-impact-time"}};
  for (const auto& [error, order] : orders) {
    std::map<std::int64_t, Rung> ladder;  // sorted by steps, each once
    const Row* like = nullptr;
    for (const Row& r : cells) {
      if (r.steps <= 0 || !r.body.empty() || r.t_s) continue;
      // A cell that failed is a rung too; the reason names it as left out.
      if (r.metric == "status" && r.status != Status::unsupported && r.status != Status::not_built)
        ladder[r.steps] = {r.h_s, std::nan(""), 0, r.steps};
      if (r.metric != error || r.status != Status::ok) continue;
      const auto& cell = figures[r.steps];
      const double growth = std::max(1.0, size_of(cell, "condition"));
      const double round_off = round_off_floor(unit, static_cast<double>(r.steps),
                                               scale(error, cell, r.h_s * static_cast<double>(r.steps)), growth);
      ladder[r.steps] = {r.h_s, r.value, std::max(r.truth_bar, round_off), r.steps};
      like = &r;
    }
    if (!like) continue;
    std::vector<Rung> rungs;
    for (const auto& [steps, rung] : ladder) rungs.push_back(rung);
    rows.push_back(order_row(order, rungs, *like));
  }
  return rows;
}

}  // namespace atwood
