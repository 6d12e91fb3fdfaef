// Observed order: least squares of log error on log h over the asymptotic window, which is found from the data.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>

#include "validation/metrics/metrics.hpp"
#include "validation/metrics/order_interval.hpp"
#include "validation/metrics/quantile.hpp"
#include "validation/metrics/slope_fit.hpp"

namespace atwood {
namespace {

constexpr double kFloorFactor = 30;   // errors below this many floors contain too much round-off
constexpr double kSlopeChange = 0.2;  // asymptotic: local slopes change by less than this
constexpr double kWidest = 0.4;       // half-width; intervals of neighbouring orders are to lie apart
constexpr double kWidestRange = 1;    // slopes that differ by more are not of one order
constexpr std::size_t kMinFitted = 4;

using metrics::fit_line;
using metrics::Line;

// Whether the local slopes of these rungs still change. y = a + b x + c x^2 by least squares (centred x, c against its
// own standard error): from the first local slope to the last they change by 2 c times the distance of the two. A
// change that is not significant (5 % level; of four rungs, with one degree of freedom, twice the standard error) is
// the rungs' scatter, not a trend.
bool slopes_change(std::span<const double> x, std::span<const double> y) {
  const std::size_t n = x.size();
  const Line line = fit_line(x, y);
  // The part of x^2 orthogonal to lines, and the component of the residual along it.
  std::vector<double> squares(n);
  for (std::size_t i = 0; i < n; ++i) squares[i] = (x[i] - x[0]) * (x[i] - x[0]);
  const Line of_squares = fit_line(x, squares);
  double along = 0, norm = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double bend = squares[i] - of_squares.intercept - of_squares.slope * x[i];
    along += bend * (y[i] - line.intercept - line.slope * x[i]);
    norm += bend * bend;
  }
  const double c = along / norm;
  const double change = std::fabs(2 * c) * (std::fabs(x[n - 1] + x[n - 2] - x[1] - x[0]) / 2);
  if (change <= kSlopeChange) return false;
  const double left = std::max(line.residual_squares - along * c, 0.0);
  const double freedom = static_cast<double>(n) - 3, limit = n == kMinFitted ? 2 : metrics::students_t(freedom, 0.975);
  return c * c * norm > limit * limit * left / freedom;
}

// Whether the coarsest rung departs from the line through the others: its local slope differs by more than
// kSlopeChange, and significantly (externally studentised residual, 1 % level).
bool first_departs(std::span<const double> x, std::span<const double> y) {
  const Line others = fit_line(x.subspan(1), y.subspan(1));
  const double n = static_cast<double>(x.size() - 1);
  if (std::fabs((y[1] - y[0]) / (x[1] - x[0]) - others.slope) <= kSlopeChange) return false;
  double mean = 0, spread = 0;
  for (double v : x.subspan(1)) mean += v / n;
  for (double v : x.subspan(1)) spread += (v - mean) * (v - mean);
  const double variance = others.residual_squares / (n - 2) * (1 + 1 / n + (x[0] - mean) * (x[0] - mean) / spread);
  const double off = y[0] - others.intercept - others.slope * x[0];
  const double limit = metrics::students_t(n - 2, 0.995);
  return off * off > limit * limit * variance;
}

// The window: the finest four rungs, and coarser ones as long as the local slopes do not change. It always ends at
// the finest rung above the floor: no rung is left out because the error stopped falling there, so an error that grows
// as h decreases shows its negative order. Both tests compare with the scatter of the rungs themselves, so the choice
// does not favour series of small scatter, and the interval covers as it would for a given window.
std::size_t first_asymptotic(std::span<const double> x, std::span<const double> y) {
  std::size_t first = x.size() - kMinFitted;
  while (first > 0) {
    const auto xs = x.subspan(first - 1), ys = y.subspan(first - 1);
    if (slopes_change(xs, ys) || first_departs(xs, ys)) break;
    --first;
  }
  return first;
}

}  // namespace

OrderFit fit_order(std::span<const double> h_s, std::span<const double> error, std::span<const double> floor) {
  OrderFit fit;
  fit.left_out.assign(h_s.size(), "");
  std::vector<int> rungs(h_s.size());
  std::iota(rungs.begin(), rungs.end(), 0);
  std::stable_sort(rungs.begin(), rungs.end(), [&](int a, int b) { return h_s[a] > h_s[b]; });

  std::vector<int> kept;
  for (int i : rungs) {
    const double f = static_cast<std::size_t>(i) < floor.size() ? floor[i] : 0;
    if (!std::isfinite(error[i]) || !(h_s[i] > 0)) fit.left_out[i] = "not finite";
    else if (!(error[i] > 0) || !(error[i] > kFloorFactor * f)) fit.left_out[i] = "floor";
    // Only rungs finer than the last failure are used: a rung between two that diverged is not reliable.
    if (fit.left_out[i] == "not finite") {
      for (int k : kept) fit.left_out[k] = "pre-asymptotic";
      kept.clear();
    } else if (fit.left_out[i].empty()) {
      kept.push_back(i);
    }
  }
  if (kept.size() < kMinFitted) {
    fit.reason = std::to_string(kept.size()) + " of " + std::to_string(rungs.size()) +
                 " rungs lie above 30 x the floor; an order needs " + std::to_string(kMinFitted);
    return fit;
  }

  std::vector<double> log_h, log_e;
  for (int i : kept) {
    log_h.push_back(std::log(h_s[i]));
    log_e.push_back(std::log(error[i]));
  }
  std::vector<double> bar;
  for (int i : kept) bar.push_back(static_cast<std::size_t>(i) < floor.size() ? floor[i] / error[i] : 0);
  const std::optional<metrics::OrderInterval> of_scatter = metrics::scatter_interval(log_h, log_e, bar);
  const bool scatters = of_scatter && !of_scatter->smooth;
  const std::size_t first = scatters ? of_scatter->first : first_asymptotic(log_h, log_e);
  for (std::size_t k = 0; k < first; ++k) fit.left_out[kept[k]] = "pre-asymptotic";
  fit.used.assign(kept.begin() + static_cast<std::ptrdiff_t>(first), kept.end());
  const auto xs = std::span(log_h).subspan(first), ys = std::span(log_e).subspan(first);
  if ((!scatters || xs.size() == kMinFitted) && slopes_change(xs, ys)) {
    fit.reason = "local slopes still change by more than 0.2 at the finest rungs";
    return fit;
  }
  metrics::OrderInterval interval =
      scatters ? *of_scatter : metrics::order_interval(xs, ys, std::span(bar).subspan(first));
  if (of_scatter) {
    interval.low = std::min(interval.low, of_scatter->low);
    interval.high = std::max(interval.high, of_scatter->high);
  }
  if (!interval.settles) {
    fit.reason = "local slopes do not settle as h decreases; finest slope " + format_measure(interval.finest, 0, 4);
    return fit;
  }
  const double half_width = (interval.high - interval.low) / 2;
  if (!(interval.range_of_slopes <= kWidestRange)) {
    fit.reason = "local slopes differ by " + format_measure(interval.range_of_slopes, 0, 2) +
                 " within the window, as where an error changes its sign";
    return fit;
  }
  if (!(half_width <= kWidest)) {
    fit.reason = "the finest rungs scatter: a half-width of " + format_measure(half_width, 0, 2) +
                 " is too wide to determine an order";
    return fit;
  }
  fit.order = (interval.low + interval.high) / 2;
  fit.half_width_95 = half_width;
  fit.finest_slope = interval.finest;
  fit.extrapolated = interval.extrapolated;
  fit.conclusive = true;
  return fit;
}

}  // namespace atwood
