// Every metric has one definition, one unit, one sign. Physics-free: energies come from reference/dynamics.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"
#include "validation/row.hpp"

namespace atwood {

struct MetricInfo { std::string name, unit, definition; };
const std::vector<MetricInfo>& all_metrics();  // the report prints the definition beside the figure

// What one cell's recording says, against the truth (rows carry scenario-free fields only: body, t_s, metric, unit,
// value, truth_bar, status, reason; the caller fills the rest). A run that did not end well gives one row,
// metric "status", with its status and reason. Never throws on NaN: a non-finite sample gives status not_finite.
std::vector<Row> measure(const Scenario& scenario, const Truth& truth, const Recording& run);

// Error and relative energy against time, for plots and growth laws. One entry a sample.
struct Series { std::vector<double> t_s, position_m, velocity_m_per_s, attitude_rad, body_rate_rad_per_s, energy; };
Series error_series(const Scenario& scenario, const Truth& truth, const Recording& run);

// ---- state error, from two samples --------------------------------------------------------------------------
double position_error_m(const BodySample& a, const BodySample& truth);
double attitude_error_rad(const BodySample& a, const BodySample& truth);  // geodesic, no cancellation, q ~ -q

// ---- observed order ---------------------------------------------------------------------------------------
struct OrderFit {
  bool conclusive = false;
  std::string reason;             // why not
  double order = 0, half_width_95 = 0;
  std::vector<int> used;          // indices of rungs in the asymptotic window
  std::vector<std::string> left_out;  // one entry a rung: "", "pre-asymptotic", "floor", "not finite"
};
OrderFit fit_order(std::span<const double> h_s, std::span<const double> error, std::span<const double> floor);

// ---- growth law: bounded, t^1/2, t, t^3/2, t^2, exponential, inconclusive ------------------------------------
struct GrowthFit { std::string law; double exponent = 0, half_width_95 = 0; std::string reason; };
GrowthFit fit_growth(std::span<const double> t_s, std::span<const double> error, double floor);

// ---- drift (slope, 1/s) told apart from oscillation (half range of the residual) ----------------------------
struct DriftFit { double slope_per_s = 0, half_width_95 = 0, oscillation = 0, largest = 0; };
DriftFit fit_drift(std::span<const double> t_s, std::span<const double> value);

// Rows of a whole ladder, from rows alone: order-*, growth-exponent-*. `cells` are all rows of one scenario x method.
std::vector<Row> fit_ladder(std::span<const Row> cells);

}  // namespace atwood
