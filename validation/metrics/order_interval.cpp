// An error is C h^p (1 + a h + b h^2 + ...): on a ladder of one method on one problem the deviations from a
// straight line in the logarithms are higher powers, not noise, and a confidence interval for noise does not contain p.
// With a model of the deviation,
//
//     log e = c + p log h + a h,      log e = c + p log h + b h^2,      log e = c + p log h + a h + b h^2,
//
// p is the slope extrapolated to h = 0. Where half powers describe the deviation better (a singular solution, a switch
// that steps do not meet), log e = c + p log h + a h^(1/2) + b h as well. A deviation that falls more slowly than any
// power, as the logarithm of h in h^p |log h|, is not covered. The interval contains the line's slope, the finest local
// slope and these, the differences from the line's slope enlarged by Roache's safety factor, and the variation that the
// bars allow.
//
// Where the bars are not known (all 0), scatter may be noise: the deviation counts as curvature where all local slopes
// change in one sense, or if a parabola is significant at the 5 % level; otherwise the interval is Student's t.
#include "validation/metrics/order_interval.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "validation/metrics/least_squares.hpp"
#include "validation/metrics/quantile.hpp"

namespace atwood::metrics {
namespace {

constexpr double kSafety = 1.25;            // Roache 1994
constexpr double kEvenWeight = 3e-3;        // rungs whose relative bar is larger weigh less, as 1 / bar^2
constexpr double kMaxUncertaintyRatio = 5;  // estimates with more than this times the line's uncertainty are not used
constexpr std::size_t kMinRungs = 4;
constexpr double kClearlyBetter = 0.25, kFarBetter = 0.1;  // of one model's squares to another's

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
  std::span<const double> x, y, bar;
  std::vector<double> sqrt_weight;  // square roots of the rungs' weights
  Powers powers;
  ColumnFit line;
  double line_uncertainty = 0;  // of the line's slope, by the bars
  ColumnFit with(std::vector<double> a) const {
    return fit_columns({powers.one, std::move(a), powers.x}, y, sqrt_weight);
  }
};

bool is_curved(const Ladder& ladder, bool monotone, const ColumnFit& parabola) {
  if (*std::min_element(ladder.bar.begin(), ladder.bar.end()) > 0) return true;
  if (monotone) return true;
  const double degrees_of_freedom = static_cast<double>(ladder.x.size()) - 3,
               limit = students_t(degrees_of_freedom, 0.975);
  return ladder.line.squares - parabola.squares > limit * limit * parabola.squares / degrees_of_freedom;
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

// Whether local slopes change faster as h decreases and so do not converge: 1/h then fits better than h or h^2.
bool diverges(const Ladder& ladder, bool monotone, const ColumnFit& linear, const ColumnFit& square) {
  const bool few = ladder.x.size() == kMinRungs;
  const ColumnFit away = ladder.with(ladder.powers.inverse);
  const bool better = away.squares < (few ? 1 : kClearlyBetter) * std::min(linear.squares, square.squares);
  return better && monotone && std::fabs(away.last - ladder.line.last) > uncertainty_by_bars(away.weight, ladder.bar);
}

}  // namespace

OrderInterval order_interval(std::span<const double> x, std::span<const double> y, std::span<const double> bar) {
  const std::size_t n = x.size();
  Ladder ladder{x, y, bar, {}, powers_of(x), {}, 0};
  for (double b : bar) ladder.sqrt_weight.push_back(kEvenWeight / std::hypot(kEvenWeight, b));
  ladder.line = fit_columns({ladder.powers.one, ladder.powers.x}, y, ladder.sqrt_weight);
  ladder.line_uncertainty = uncertainty_by_bars(ladder.line.weight, bar);
  const double slope = ladder.line.last;
  const ColumnFit linear = ladder.with(ladder.powers.h), square = ladder.with(ladder.powers.h_squared);
  const ColumnFit parabola = ladder.with(ladder.powers.x_squared);
  const bool monotone = slopes_monotone(x, y, bar);

  OrderInterval out;
  const double last = 1 / (x[n - 1] - x[n - 2]);
  out.finest = (y[n - 1] - y[n - 2]) * last;
  out.extrapolated = linear.last;
  out.curved = is_curved(ladder, monotone, parabola);
  const double scatter = out.curved && n > kMinRungs ? scatter_half_width(ladder, parabola, 3)
                                                     : scatter_half_width(ladder, ladder.line, 2);
  out.low = slope - scatter;
  out.high = slope + scatter;
  if (out.curved) {
    const auto take = [&](double estimate, std::span<const double> weight) {
      const double uncertainty = uncertainty_by_bars(weight, bar), shift = estimate - slope;
      if (std::fabs(shift) <= uncertainty && uncertainty > kMaxUncertaintyRatio * ladder.line_uncertainty) return;
      out.low = std::min(out.low, slope + kSafety * shift - uncertainty);
      out.high = std::max(out.high, slope + kSafety * shift + uncertainty);
    };
    take(linear.last, linear.weight);
    take(square.last, square.weight);
    if (n > kMinRungs) {
      const Powers& p = ladder.powers;
      const ColumnFit both = fit_columns({p.one, p.h, p.h_squared, p.x}, y, ladder.sqrt_weight);
      take(both.last, both.weight);
      const ColumnFit halves = fit_columns({p.one, p.root, p.h, p.x}, y, ladder.sqrt_weight);
      if (monotone && halves.squares < kFarBetter * both.squares) take(halves.last, halves.weight);
    }
    std::vector<double> finest(n, 0.0);
    finest[n - 1] = last;
    finest[n - 2] = -last;
    take(out.finest, finest);
    out.settles = !diverges(ladder, monotone, linear, square);
  }
  out.low -= ladder.line_uncertainty;
  out.high += ladder.line_uncertainty;
  return out;
}

}  // namespace atwood::metrics
