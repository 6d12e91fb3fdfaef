// An error is C h^p (1 + a h + b h^2 + ...): on a ladder of one method on one problem the deviations from a
// straight line in the logarithms are higher powers, not noise, and a confidence interval for noise does not contain p.
// With a model of the deviation,
//
//     log e = c + p log h + a h,      log e = c + p log h + b h^2,      log e = c + p log h + a h + b h^2,
//
// p is the slope extrapolated to h = 0. Half powers (a singular solution, a switch that steps do not meet) change
// slopes more slowly than h does, and so do whole powers where a h is not small: the slope of 1 + a h is
// a h / (1 + a h). Where half powers describe the deviation better, or as well within the bars,
//
//     log e = c + p log h + a h^(1/2),      log e = c + p log h + log(1 + a h^(1/2)),
//     log e = c + p log h + a h^(1/2) + b h
//
// are added. The interval contains the line's slope, the finest local slope and these, the differences from the line's
// slope enlarged by Roache's safety factor, and the variation that the bars allow. A deviation that falls more slowly
// than these, as the logarithm of h in h^p |log h|, is not covered.
//
// Where the bars are not known (all 0), scatter may be noise: the deviation counts as curvature where all local slopes
// change in one sense, where a parabola is significant at the 5 % level, or the model with h and h^2 at the 1 % level;
// otherwise the interval is Student's t.
#include "validation/metrics/order_interval.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "validation/metrics/least_squares.hpp"
#include "validation/metrics/quantile.hpp"

namespace atwood::metrics {
namespace {

constexpr double kSafety = 1.25;      // Roache 1994
constexpr double kEvenWeight = 3e-3;  // rungs whose relative bar is larger weigh less, as 1 / bar^2
constexpr double kRoundOff = 1e-14;   // of the logarithms
// Estimates that differ from the line's slope by less than the bars allow, and that are more uncertain than this times
// the line's slope, are not used: the bars hide that deviation. Half powers change slopes the least.
constexpr double kMaxUncertaintyRatio = 5, kMaxOfHalfPower = 10;
constexpr std::size_t kMinRungs = 4;

// The most by which the rungs' bars can move sum_i weight_i y_i.
double uncertainty_by_bars(std::span<const double> weight, std::span<const double> bar) {
  double sum = 0;
  for (std::size_t i = 0; i < weight.size(); ++i) sum += std::fabs(weight[i]) * bar[i];
  return sum;
}

// The columns of the models above, h in units of the coarsest rung's.
struct Powers {
  std::vector<double> one, x, x_squared, h, h_squared, root, inverse;
};
Powers powers_of(std::span<const double> x) {
  Powers p;
  for (double v : x) {
    const double from = v - x.front(), h = std::exp(from);
    p.one.push_back(1);
    p.x.push_back(v);
    p.x_squared.push_back(from * from);
    p.h.push_back(h);
    p.h_squared.push_back(h * h);
    p.root.push_back(std::sqrt(h));
    p.inverse.push_back(1 / h);
  }
  return p;
}

// Whether all local slopes change in one sense; changes within the bars do not count.
bool slopes_monotone(std::span<const double> x, std::span<const double> y, std::span<const double> bar) {
  bool up = false, down = false;
  for (std::size_t i = 0; i + 2 < x.size(); ++i) {
    const double a = 1 / (x[i + 1] - x[i]), b = 1 / (x[i + 2] - x[i + 1]);
    const double change = (y[i + 2] - y[i + 1]) * b - (y[i + 1] - y[i]) * a;
    const std::vector<double> weight{a, a + b, b};
    const double within = uncertainty_by_bars(weight, bar.subspan(i, 3));
    up = up || change > within;
    down = down || change < -within;
  }
  return up != down;
}

struct Ladder {
  std::span<const double> x, y;
  std::vector<double> bar, sqrt_weight;  // bars with round-off; square roots of the rungs' weights
  Powers powers;
  ColumnFit line;
  double line_uncertainty = 0;  // of the line's slope, by the bars
  double rungs() const { return static_cast<double>(x.size()); }
  ColumnFit with(std::vector<double> a) const {
    return fit_columns({powers.one, std::move(a), powers.x}, y, sqrt_weight);
  }
  ColumnFit with(std::vector<double> a, std::vector<double> b) const {
    return fit_columns({powers.one, std::move(a), std::move(b), powers.x}, y, sqrt_weight);
  }
};
Ladder ladder_of(std::span<const double> x, std::span<const double> y, std::span<const double> bar) {
  Ladder ladder{x, y, {}, {}, powers_of(x), {}, 0};
  for (double b : bar) {
    ladder.bar.push_back(b + kRoundOff);
    ladder.sqrt_weight.push_back(kEvenWeight / std::hypot(kEvenWeight, b));
  }
  ladder.line = fit_columns({ladder.powers.one, ladder.powers.x}, y, ladder.sqrt_weight);
  ladder.line_uncertainty = uncertainty_by_bars(ladder.line.weight, ladder.bar);
  return ladder;
}

// Whether one parameter more than the line's describes the rungs better, at a level of 2 (1 - p): Student's t.
bool significant(const Ladder& ladder, double squares, double p) {
  const double degrees_of_freedom = ladder.rungs() - 3, limit = students_t(degrees_of_freedom, p);
  return ladder.line.squares - squares > limit * limit * squares / degrees_of_freedom;
}

bool is_curved(const Ladder& ladder, bool monotone, const ColumnFit& parabola) {
  if (*std::min_element(ladder.bar.begin(), ladder.bar.end()) > 2 * kRoundOff) return true;
  if (monotone || significant(ladder, parabola.squares, 0.975)) return true;
  // Slopes that turn. The ratio r of squares with 2 parameters more and m degrees of freedom left is below r with
  // probability r^(m/2) where the rungs scatter about a line (the F distribution of 2 and m).
  if (ladder.x.size() == kMinRungs) return false;
  const double ratio = ladder.with(ladder.powers.h, ladder.powers.h_squared).squares / ladder.line.squares;
  return std::pow(ratio, (ladder.rungs() - 4) / 2) < 0.01;
}

// 95 % of the line's slope by the scatter about the line, or, where that is curved, about the parabola.
double scatter_half_width(const Ladder& ladder, const ColumnFit& left, double parameters) {
  double variance = 0;
  for (std::size_t i = 0; i < ladder.x.size(); ++i) {
    const double a = ladder.line.weight[i] / ladder.sqrt_weight[i];
    variance += a * a;
  }
  const double degrees_of_freedom = static_cast<double>(ladder.x.size()) - parameters;
  return students_t(degrees_of_freedom, 0.975) * std::sqrt(left.squares / degrees_of_freedom * variance);
}

// Whether a model with these columns, and y, is one that the bars do not exclude: what it leaves of a parabola's bend
// is no more than the bars allow.
bool within_bars(const Ladder& ladder, const std::vector<double>& column, std::span<const double> y) {
  const Powers& p = ladder.powers;
  const ColumnFit more = fit_columns({p.one, column, p.x, p.x_squared}, y, ladder.sqrt_weight);
  return std::fabs(more.last) <= uncertainty_by_bars(more.weight, ladder.bar);
}

// log e = c + p log h + log(1 + a h^(1/2)), by Gauss and Newton from a = 0: its tangent at the solution.
struct HalfPower {
  ColumnFit fit;
  bool converged = false, within_bars = false;
};
HalfPower fit_half_power(const Ladder& ladder) {
  constexpr int max_iterations = 30;
  constexpr double max_a = 100, tolerance = 1e-10;  // a larger one is an order of p + 1/2 on all rungs
  HalfPower out;
  const std::vector<double>& z = ladder.powers.root;
  std::vector<double> column(z.size()), y(z.size());
  double a = 0;
  const auto to_tangent = [&] {
    for (std::size_t i = 0; i < z.size(); ++i) {
      column[i] = z[i] / (1 + a * z[i]);
      y[i] = ladder.y[i] - std::log1p(a * z[i]) + a * column[i];
    }
  };
  for (int k = 0; k < max_iterations && a < max_a && !out.converged; ++k) {
    to_tangent();
    const double next = fit_columns({ladder.powers.one, ladder.powers.x, column}, y, ladder.sqrt_weight).last, was = a;
    if (!std::isfinite(next)) return out;
    a = std::clamp(next, (a - 0.98) / 2, 2 * a + 1);  // 1 + a z > 0
    out.converged = std::fabs(a - was) < tolerance * (1 + a);
  }
  to_tangent();
  out.fit = fit_columns({ladder.powers.one, column, ladder.powers.x}, y, ladder.sqrt_weight);
  out.within_bars = within_bars(ladder, column, y);
  return out;
}

// Whether the local slopes do not converge, or more slowly than with any power of at least 1/4: all change in one
// sense, and a slope linear in log h (the parabola) or in 1/h describes them better than one of h^(1/2), h or h^2.
// The level is 10 % with four rungs, where one degree of freedom is left, and 0.5 % with more.
bool diverges(const Ladder& ladder) {
  const Powers& p = ladder.powers;
  const double away = std::min(ladder.with(p.x_squared).squares, ladder.with(p.inverse).squares);
  const double towards =
      std::min({ladder.with(p.h).squares, ladder.with(p.h_squared).squares, ladder.with(p.root).squares});
  return away < towards && significant(ladder, away, ladder.x.size() == kMinRungs ? 0.95 : 0.9975) &&
         !within_bars(ladder, p.root, ladder.y);
}

// The largest local slope less the smallest, beyond what the bars allow.
double range_of_slopes(const Ladder& ladder) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t i = 0; i + 1 < ladder.x.size(); ++i) {
    const double dx = ladder.x[i + 1] - ladder.x[i], slope = (ladder.y[i + 1] - ladder.y[i]) / dx;
    const double within = (ladder.bar[i] + ladder.bar[i + 1]) / std::fabs(dx);
    least = std::min(least, slope + within);
    most = std::max(most, slope - within);
  }
  return most - least;
}

// Widens the interval by the models' slopes at h = 0 and by the finest slope.
void add_models(const Ladder& ladder, bool monotone, const ColumnFit& linear, const ColumnFit& square,
                OrderInterval& out) {
  const Powers& p = ladder.powers;
  const double slope = ladder.line.last;
  const auto take = [&](double estimate, std::span<const double> weight, double most = kMaxUncertaintyRatio) {
    const double shift = estimate - slope, uncertainty = uncertainty_by_bars(weight, ladder.bar);
    if (std::fabs(shift) <= uncertainty && uncertainty > most * ladder.line_uncertainty) return;
    out.low = std::min(out.low, slope + kSafety * shift - uncertainty);
    out.high = std::max(out.high, slope + kSafety * shift + uncertainty);
  };
  take(linear.last, linear.weight);
  take(square.last, square.weight);
  if (ladder.x.size() > kMinRungs) {
    const ColumnFit both = ladder.with(p.h, p.h_squared), halves = ladder.with(p.root, p.h);
    take(both.last, both.weight);
    if (monotone && halves.squares < both.squares) take(halves.last, halves.weight);
  }
  const ColumnFit root = ladder.with(p.root);
  if (root.squares < linear.squares) take(root.last, root.weight);
  const HalfPower half = fit_half_power(ladder);
  if (half.converged && (half.within_bars || half.fit.squares < linear.squares))
    take(half.fit.last, half.fit.weight, kMaxOfHalfPower);
  std::vector<double> finest(ladder.x.size(), 0.0);
  finest.back() = 1 / (ladder.x.back() - ladder.x[ladder.x.size() - 2]);
  finest[finest.size() - 2] = -finest.back();
  take(out.finest, finest);
}

}  // namespace

OrderInterval order_interval(std::span<const double> x, std::span<const double> y, std::span<const double> bar) {
  const std::size_t n = x.size();
  const Ladder ladder = ladder_of(x, y, bar);
  const ColumnFit linear = ladder.with(ladder.powers.h), square = ladder.with(ladder.powers.h_squared);
  const ColumnFit parabola = ladder.with(ladder.powers.x_squared);
  const bool monotone = slopes_monotone(x, y, ladder.bar);

  OrderInterval out;
  out.finest = (y[n - 1] - y[n - 2]) / (x[n - 1] - x[n - 2]);
  out.extrapolated = linear.last;
  out.range_of_slopes = range_of_slopes(ladder);
  out.curved = is_curved(ladder, monotone, parabola);
  const double scatter = out.curved && n > kMinRungs ? scatter_half_width(ladder, parabola, 3)
                                                     : scatter_half_width(ladder, ladder.line, 2);
  out.low = ladder.line.last - scatter - ladder.line_uncertainty;
  out.high = ladder.line.last + scatter + ladder.line_uncertainty;
  if (out.curved) {
    add_models(ladder, monotone, linear, square, out);
    // Where the bars explain what the finest rungs do, the coarser ones alone do not tell.
    const bool finest_diverge =
        n == kMinRungs || diverges(ladder_of(x.last(kMinRungs), y.last(kMinRungs), bar.last(kMinRungs)));
    out.settles = !(monotone && diverges(ladder) && finest_diverge);
  }
  return out;
}

}  // namespace atwood::metrics
