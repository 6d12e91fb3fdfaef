// Every metric has one definition, unit and sign. No physics here: energies come from reference/dynamics.
//
// A row without a body has the largest figure of all bodies. `truth_bar` is the bar of the value in its own unit: the
// truth's for errors, the 95 % half-width for what is fitted (orders, growth exponents, drift).
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"
#include "validation/row.hpp"

namespace atwood {

struct MetricInfo {
  std::string name, unit, definition;
  // Of the definition; a figure of another version is another figure (baselines have both). What has changed since 1.
  int version = 1;
  std::string changed = {};
};
const std::vector<MetricInfo>& all_metrics();  // the report prints the definition beside the figure

// The rows of one cell's recording, compared with the truth (they have only the fields body, t_s, metric, unit, value,
// truth_bar, status, reason; the caller fills the rest). A run that failed gives one row,
// metric "status", with its status and reason. Never throws on NaN: a non-finite sample gives status not_finite.
std::vector<Row> measure(const Scenario& scenario, const Truth& truth, const Recording& run);

// Error and relative energy against time, for plots and growth laws.
struct Series {
  std::vector<double> t_s, position_m, velocity_m_per_s, attitude_rad, body_rate_rad_per_s, energy;
};
// One entry per sample of the run; empty where the recording cannot be measured.
Series error_series(const Scenario& scenario, const Truth& truth, const Recording& run);

// ---- state error, from two samples --------------------------------------------------------------------------
double position_error_m(const BodySample& a, const BodySample& truth);
double attitude_error_rad(const BodySample& a, const BodySample& truth);  // geodesic, no cancellation, q ~ -q

// ---- observed order ---------------------------------------------------------------------------------------
// `floor` is each rung's known bar; 0 or missing: not known. The interval holds the slope of the line through the
// window, the slope of its two finest rungs and the slope extrapolated to h = 0; where the rungs scatter, p of
// h^p (1 + a h) under noise (order_interval.cpp). `order` is its middle. It is meant for errors
// C h^p (1 + powers of h, h^(1/2) among them); of h^p |log h| it need not contain p. Inconclusive: local slopes that
// do not settle as h decreases, change by more than 0.2 at the finest rungs, or differ by more than 1; a half-width of
// more than 0.4.
struct OrderFit {
  bool conclusive = false;
  std::string reason;  // why it is inconclusive
  double order = 0, half_width_95 = 0;
  double finest_slope = 0, extrapolated = 0;
  std::vector<int> used;              // indices of rungs in the asymptotic window
  std::vector<std::string> left_out;  // one entry per rung: "", "pre-asymptotic", "floor", "not finite"
};
// Of the errors of a ladder's rungs, one entry a rung. At least four rungs above 30 floors are needed.
OrderFit fit_order(std::span<const double> h_s, std::span<const double> error, std::span<const double> floor);

// ---- growth law: bounded, t^1/2, t, t^3/2, t^2, exponential, inconclusive ------------------------------------
struct GrowthFit {
  std::string law;
  double exponent = 0, half_width_95 = 0;
  double rate_per_s = 0, rate_half_width_95 = 0;  // of an exponential; else 0
  std::string reason;
};
// Of one run, by the largest error of each of twelve windows of time, or, for t beside an offset, by their means. Where
// two powers of like size are present over the run no single law is named.
GrowthFit fit_growth(std::span<const double> t_s, std::span<const double> error, double floor);
// At the round-off floor, where one run is a single random sample: runs[k][i] is the error of run k at t_s[i], at least
// 32 runs; the law of their root mean square, its interval by bootstrap over the runs.
GrowthFit fit_growth_ensemble(std::span<const double> t_s, std::span<const std::vector<double>> runs);
// Names the law nearest to the exponent if it is within 0.2, the half-width is at most 0.2 (the next law is 0.5
// away), and the whole interval lies within `whole_within` of it; else `inconclusive`, with the reason.
void name_law(GrowthFit& fit, double whole_within = 0.4);

// Three steps cannot show whether they lie in the asymptotic range: their order is defined by GCI32 / (r^p GCI21) = 1.
// A fourth step can: the orders of the finer and of the coarser three agree to 0.1 with each other, and with the
// formal order where that is known (else 0).
enum class AsymptoticRange { not_tested, agrees, disagrees };
AsymptoticRange asymptotic_range(double finer_order, double coarser_order, double formal_order);

// ---- runs without a truth: three steps, Richardson extrapolation, grid convergence index ---------------------
// a scalar, or a vector whose norm counts
struct GridLevel {
  double h_s = 0;
  std::vector<double> value;
};
struct GridConvergence {
  enum class Kind {
    monotone,
    oscillatory,
    divergent,
    none,      // the finest two agree exactly
    not_found  // unequal refinement: the order is not between -64 and 64
  } kind = Kind::divergent;
  double order = 0;         // negative: the differences grow as h shrinks
  double index = 0;         // 1.25 |f2 - f1| / (r^p - 1), in the unit of f: the band about the finest value
  double index_coarse = 0;  // 1.25 |f3 - f2| / (r32^p - 1): about the middle value
  double difference = 0;    // |f2 - f1|
  std::vector<double> extrapolated;
};
// Of three steps, the finest first; all values have the same number of components.
GridConvergence grid_convergence(const GridLevel& fine, const GridLevel& medium, const GridLevel& coarse);
// "monotone", ...: as reasons of rows name it.
std::string to_string(GridConvergence::Kind kind);

// ---- tolerance calibration: slope of log error on log rtol (1: proportional), tolerances near the floor left out --
struct ToleranceFit {
  bool conclusive = false;
  std::string reason;
  double exponent = 0, half_width_95 = 0;
  int used = 0;
};
// Of runs at several tolerances, one entry a run.
ToleranceFit fit_tolerance(std::span<const double> rtol, std::span<const double> error, std::span<const double> floor);

// ---- chaos: the mean of ln(d_end / d_start) / T over stretches, one after another; stretches 0: too few (9) -------
struct LyapunovFit {
  double exponent_per_s = std::numeric_limits<double>::quiet_NaN(), half_width_95 = 0;
  int stretches = 0;
  // Of the separation over the stretches used, and of one that grows like t^2. Not resolved: the interval excludes 0,
  // but holds rates by which the separation grows no more than that.
  double e_foldings = 0, e_foldings_of_power = 0;
  bool resolved = true;
};
// local_exponents: one of each stretch of stretch_s [1/s]; the first tenth is left out, in which the separation turns
// to the direction of fastest growth.
LyapunovFit fit_lyapunov(std::span<const double> local_exponents, double stretch_s);

// At the round-off floor, where one run's drift is a single random sample: the mean over runs (at least 32) of each
// run's least squares slope, the half-width from a bootstrap over the runs. runs[k][i] is run k's value at t_s[i].
struct EnsembleDrift {
  double slope_per_s = std::numeric_limits<double>::quiet_NaN(), half_width_95 = 0;
  std::string reason;  // why there is no figure
};
EnsembleDrift fit_drift_ensemble(std::span<const double> t_s, std::span<const std::vector<double>> runs);

// ---- scaling: time against the number of bodies, T ~ N^exponent; and T / log N, whose exponent is 1 for N log N ---
// Least squares on the logs with 95 % half-widths (Student's t); fewer than 4 rungs: not a number.
struct ScalingFit {
  int rungs = 0;
  double exponent = std::numeric_limits<double>::quiet_NaN(), half_width_95 = exponent;
  double exponent_over_log = exponent, half_width_over_log_95 = exponent;
};
ScalingFit fit_scaling(std::span<const double> bodies, std::span<const double> seconds);

// ---- drift (slope, 1/s) and oscillation (half range of the residual) ----------------------------------------
// The half-width takes neighbouring residuals as correlated. Where the residual is not stationary (a random walk, a
// slope that changes), or fewer than ten samples cannot show that it is, there is no such interval: `stationary` is
// false, the slope is the mean one from the first to the last value without the oscillation, and the half-width
// Student's over the slopes of eight equal parts, or of as many as there are (infinite: the series is too short for
// four). Shorter series than 4: all 0.
struct DriftFit {
  double slope_per_s = 0, half_width_95 = 0, oscillation = 0, largest = 0, period_s = 0;  // period 0: none
  bool stationary = true;
  bool one_sign = false;  // not stationary, and all eight parts rise or all fall: 1 of 128 random walks does
};
DriftFit fit_drift(std::span<const double> t_s, std::span<const double> value);

// The amplification of round-off: growth of a perturbation of the initial state over the run, the perturbation relative
// to each vector's own size there (as rounding is), the growth in units of the trajectory's size; the largest of four
// directions. The reference's own equations, classical RK4 in double, states a part in 1e-7 apart. (truth.condition
// scales perturbations by the trajectory's size instead and is larger: it is the condition number of the problem.)
// Where 4000 steps do not end where the truth does, more are taken. Where as many as are tried do not either, of a
// bare problem and with contacts it is a lower bound: 1 + t_end v / size, the growth of free flight.
struct PerturbationGrowth {
  double value = 0;
  bool followed = true;  // false: a lower bound
};
PerturbationGrowth perturbation_growth(const Scenario& scenario, const Truth& truth);

// The error by round-off alone after `steps` steps, estimated before any run, so that it does not depend on the
// measured error: u sqrt(steps) size amplification. u is the unit round-off of the scalar (2^-53 in double), `size` the
// largest value of the quantity along the true motion, `amplification` how much a relative perturbation grows over the
// run. Unbiased rounding makes each step's error an independent draw of about u x size; their sum grows as sqrt(steps)
// (Henrici 1962, ch. 1; for orbits: Brouwer 1937).
double round_off_floor(double unit_round_off, double steps, double size, double amplification);
// Condition x unit round-off x size, from the rows of one cell, which name its scalar: an error at the end of a run
// (error-*-end) cannot be expected below it, for rounding the initial state alone causes it. NaN for another metric,
// and where the rows have no condition or a lower bound of it.
double accuracy_floor(const std::string& metric, std::span<const Row> cell);
// Unit round-off of the scalar that a method id names or its engine uses: "@float" and engines that end in 32: 2^-24;
// "@long-double": 2^-64; "@quad": 2^-113; else 2^-53.
double unit_round_off(const std::string& method);

// At how many instants the rungs of a ladder were observed: the scene's own samples, and what each rung was asked for.
struct LadderInstants {
  std::int64_t samples = 0;
  std::map<std::int64_t, std::int64_t> shared = {};  // by steps; empty: not known, and taken as the same
  bool has_fewer(std::int64_t steps) const;          // than another rung
  std::string words() const;                         // for reasons
};

// Rows of a whole ladder, from the rows of its cells: order-{position,velocity,attitude,body-rate,joint-coordinate} of
// the largest error, and the same of the end's, the largest and the root mean square one (-end, -max, -rms), and
// order-impact-time from impact-time-error. `cells` are all rows of one scenario x method. In an order row
//   value      the order; NaN where it is inconclusive (a gate on it is then unverifiable)
//   truth_bar  the 95 % half-width
//   reason     the window in steps, the interval, what was left out and why; or "inconclusive: ..."
// The floor of a rung is the larger of the truth's bar and round_off_floor. Methods with a tolerance have no order in
// h: no rows for them. (Growth laws need a series: `measure` fits them, one row per cell.)
std::vector<Row> fit_ladder(std::span<const Row> cells, const LadderInstants& instants = {});

// Rows of the same ladder from the end states of its runs: gci-position, richardson-order-position, and gci-effectivity
// where a truth is known. The finest three rungs whose differences lie above 30 x the floor.
// `formal_order`: what the method claims for this motion; 0: not known.
struct LadderEnd {
  std::int64_t steps = 0;
  double h_s = 0;
  Sample last;
  double formal_order = 0;
};
std::vector<Row> fit_ends(const Scenario& scenario, std::span<const LadderEnd> ends, std::span<const Row> cells);
// round-off-best-error and -step of a ladder that goes past its floor; none where the least error has not been passed.
std::vector<Row> fit_round_off_v(std::span<const Row> cells);
// tolerance-ratio of each tolerance, tolerance-exponent of each method (its id without the tolerance): all rows of a
// scenario.
std::vector<Row> fit_tolerances(std::span<const Row> rows);

// step-time and run-time: one median over the timed pass's repeats [s], of a step and of the run; their bars are the
// distance to the farther end of the median's interval by order statistics (NaN for a single repeat). step-time-p95 for
// at least 20 repeats. None where nothing was timed. `steps`: those that the run took.
std::vector<Row> timing_rows(const Outcome& outcome, std::int64_t steps);

// Time of A over time of B from pairs A B A B, a[i] beside b[i]: the median of the pairs' ratios and its 95 % interval
// by bootstrap over pairs (percentile; 2000 resamples of a fixed seed; fewer than 9 pairs: the range of the ratios).
// Pairs that are not finite and positive are left out; NaN when none is left.
struct PairedRatio {
  double ratio = std::numeric_limits<double>::quiet_NaN(), low = ratio, high = ratio;
  int pairs = 0;
};
PairedRatio paired_ratio(std::span<const double> a, std::span<const double> b);

// A measured value with its bar, as reports print it; below three bars only an upper limit, "<= v + b".
std::string format_measure(double value, double bar, int digits = 3);

}  // namespace atwood
