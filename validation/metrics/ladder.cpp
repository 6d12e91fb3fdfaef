// CellValues of a whole ladder, from the rows of its cells.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>

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
  if (metric.starts_with("error-position")) return size_of(cell, "size-position");
  if (metric.starts_with("error-velocity")) return size_of(cell, "size-velocity");
  if (metric.starts_with("error-body-rate")) return size_of(cell, "size-body-rate");
  if (metric.starts_with("error-attitude")) return 1;
  if (metric.starts_with("error-joint-coordinate")) return std::max(1.0, size_of(cell, "size-joint-coordinate"));
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

// The rungs of a ladder with this error, and their order.
struct Order {
  std::vector<Rung> rungs;
  OrderFit fit;
  std::string left_out;  // rungs that have not all instants of the others
  const Row* like = nullptr;
};

Row order_row(const std::string& metric, const Order& order, const std::string& note) {
  const OrderFit& fit = order.fit;
  Row row = metrics::row(metric, fit.conclusive ? fit.order : std::nan(""), fit.conclusive ? fit.half_width_95 : 0,
                         window_text(fit, order.rungs) + order.left_out + note);
  row.scenario = order.like->scenario;
  row.method = order.like->method;
  row.settings_hash = order.like->settings_hash;
  row.provenance = order.like->provenance;
  return row;
}

using CellValues = std::map<std::int64_t, std::map<std::string, double>>;  // steps -> metric -> value

// `of_run`: an error of the whole run, to be taken over the same instants on all rungs.
Order order_of(std::span<const Row> cells, const CellValues& figures, const std::string& error,
               const LadderInstants& instants, bool of_run) {
  const double unit = unit_round_off(cells.front().method);
  std::map<std::int64_t, Rung> ladder;  // sorted by steps, each once
  Order order;
  std::string fewer;
  for (const Row& r : cells) {
    if (r.steps <= 0 || !r.body.empty() || r.t_s) continue;
    if (of_run && instants.has_fewer(r.steps)) {
      if (r.metric == error) fewer += (fewer.empty() ? "" : " ") + std::to_string(r.steps);
      continue;
    }
    // A cell that failed is a rung too; the reason names it as left out.
    if (r.metric == "status" && r.status != Status::unsupported && r.status != Status::not_built)
      ladder[r.steps] = {r.h_s, std::nan(""), 0, r.steps};
    if (r.metric != error || r.status != Status::ok) continue;
    const auto& cell = figures.at(r.steps);
    const double growth = std::max(1.0, size_of(cell, "condition"));
    const double round_off = round_off_floor(unit, static_cast<double>(r.steps),
                                             scale(error, cell, r.h_s * static_cast<double>(r.steps)), growth);
    ladder[r.steps] = {r.h_s, r.value, std::max(r.truth_bar, round_off), r.steps};
    order.like = &r;
  }
  if (order.like == nullptr) return order;
  if (!fewer.empty()) order.left_out = "; left out: " + fewer + " (fewer instants)";
  std::vector<double> h, errors, floor;
  for (const auto& [steps, rung] : ladder) {
    order.rungs.push_back(rung);
    h.push_back(rung.h_s);
    errors.push_back(rung.error);
    floor.push_back(rung.floor);
  }
  order.fit = fit_order(h, errors, floor);
  return order;
}

// The orders of the end, of the largest and of the root mean square error. Where the end's is above the largest's
// beyond both intervals, errors vanish at the samples that do not between them.
void append_orders(std::span<const Row> cells, const CellValues& figures, const std::string& quantity,
                   const LadderInstants& instants, std::vector<Row>& rows) {
  const std::string name = "order-" + quantity, error = "error-" + quantity;
  const std::string of_largest = quantity == "joint-coordinate" ? error : error + "-max";
  const Order end = order_of(cells, figures, error + "-end", instants, false),
              largest = order_of(cells, figures, of_largest, instants, true),
              rms = order_of(cells, figures, error + "-rms", instants, true);
  std::string note;
  if (end.fit.conclusive && largest.fit.conclusive &&
      end.fit.order - end.fit.half_width_95 > largest.fit.order + largest.fit.half_width_95)
    note = "; superconvergent at the samples: order " + format_measure(end.fit.order, 0) + " +/- " +
           significant(end.fit.half_width_95) + " at the end, " + format_measure(largest.fit.order, 0) + " +/- " +
           significant(largest.fit.half_width_95) + " over the run";
  const std::string where = instants.words();
  if (largest.like != nullptr) rows.push_back(order_row(name, largest, where + note));
  if (end.like != nullptr) rows.push_back(order_row(name + "-end", end, note));
  if (largest.like != nullptr) rows.push_back(order_row(name + "-max", largest, where + note));
  if (rms.like != nullptr) rows.push_back(order_row(name + "-rms", rms, where));
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

bool LadderInstants::has_fewer(std::int64_t steps) const {
  const auto found = shared.find(steps);
  return found != shared.end() &&
         std::any_of(shared.begin(), shared.end(), [&](const auto& other) { return other.second > found->second; });
}

std::string LadderInstants::words() const {
  std::int64_t most = 0, divisor = 0;
  for (const auto& [steps, count] : shared) most = std::max(most, count), divisor = std::gcd(divisor, steps);
  if (samples == 0 || most == 0) return "";
  if (most == samples)
    return "; over the " + std::to_string(samples) + " samples alone" +
           (divisor == samples ? ": these steps share no other instant" : "");
  return "; over instants between the " + std::to_string(samples) + " samples too";
}

std::vector<Row> fit_ladder(std::span<const Row> cells, const LadderInstants& instants) {
  std::vector<Row> rows;
  if (cells.empty() || cells.front().method.find(':') != std::string::npos) return rows;
  CellValues figures;
  for (const Row& r : cells)
    if (r.status == Status::ok && r.body.empty() && !r.t_s) figures[r.steps][r.metric] = r.value;
  for (const char* quantity : {"position", "velocity", "attitude", "body-rate", "joint-coordinate"})
    append_orders(cells, figures, quantity, instants, rows);
  const Order impacts = order_of(cells, figures, "impact-time-error", instants, false);
  if (impacts.like != nullptr) rows.push_back(order_row("order-impact-time", impacts, ""));
  return rows;
}

}  // namespace atwood
