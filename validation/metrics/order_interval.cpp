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
// Errors that scatter. A ladder may have noise that no bar states: the largest error jumps from one instant to another,
// contacts are met at other places in their steps. Whether noise or a further power bends four or five rungs, they do
// not tell: a line's interval, or a window chosen by what is significant, then excludes p in most cases. So the
// deviation is a part of what is estimated, and nothing is chosen by it:
//
//     log e_i = c + p log h_i + log(1 + a h_i / h_0) + s n_i,     h_0 the coarsest rung's, n_i normal.
//
// b = log(1 + a) is the logarithm of how far the coarsest rung departs from the power; where it does so by more than a
// factor of 6 upwards or 0.7 downwards the window is too coarse. With b given, p is the slope of a line, and its
// posterior with the prior s^(k - 1) of the noise is Student's t of n - 2 - k degrees of freedom (n rungs). With b
// uniform, the interval contains the central 95 % of the mixture of these, weighted by the likelihood RSS(b)^-(n-2-k)/2
// (Box and Tiao 1973, 2.2 and 8.2). k = 0 is Jeffreys's prior. Of noisy ladders those whose rungs happen to lie close
// to a curve pass for exact, and those that scatter are inconclusive: k = 0.3 is calibrated such that the conclusive
// ones are still right (order_scatter_test.cpp). The window takes all rungs that this model describes.
//
// Where another smooth deviation describes the rungs much better (half powers, several terms, slopes that do not
// settle) the rungs do not scatter, and the interval of the first kind counts. As noise has that shape in one case of
// twenty, the interval of the second kind is joined to it, unless the bars explain what the better one leaves, or it is
// better by a further factor of 100.
#include "validation/metrics/order_interval.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "validation/metrics/bisection.hpp"
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
// Of the coarsest rung's error over the power's.
constexpr double kMinDeparture = 0.7, kMaxDeparture = 6;
constexpr double kMaxRange = 1;   // of local slopes in one window
constexpr double kCaution = 0.3;  // k above
// Ratios of what two models leave, per degree of freedom, from which on one is much better: with as many parameters,
// and with one more.
constexpr double kMuchBetter = 10, kMuchBetterByOneMore = 100;
constexpr double kCertain = 100;  // times these: noise does not explain it

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
  double norm_of_bars = 0;      // the most that the bars can leave of a right model: root of its squares
  double rungs() const { return static_cast<double>(x.size()); }
  ColumnFit with(std::vector<double> a) const {
    return fit_columns({powers.one, std::move(a), powers.x}, y, sqrt_weight);
  }
  ColumnFit with(std::vector<double> a, std::vector<double> b) const {
    return fit_columns({powers.one, std::move(a), std::move(b), powers.x}, y, sqrt_weight);
  }
};
Ladder ladder_of(std::span<const double> x, std::span<const double> y, std::span<const double> bar) {
  Ladder ladder{x, y, {}, {}, powers_of(x), {}, 0, 0};
  for (double b : bar) {
    ladder.bar.push_back(b + kRoundOff);
    ladder.sqrt_weight.push_back(kEvenWeight / std::hypot(kEvenWeight, b));
    ladder.norm_of_bars = std::hypot(ladder.norm_of_bars, ladder.bar.back() * ladder.sqrt_weight.back());
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

// The standard error of a fit's last coefficient, for scatter of variance 1 on each rung.
double standard_error(const Ladder& ladder, const ColumnFit& fit) {
  double norm = 0;
  for (std::size_t i = 0; i < fit.weight.size(); ++i) norm = std::hypot(norm, fit.weight[i] / ladder.sqrt_weight[i]);
  return norm;
}

// 95 % of the line's slope by the scatter about the parabola, or, of four rungs, about the line.
double scatter_half_width(const Ladder& ladder, const ColumnFit& parabola) {
  const bool few = ladder.x.size() == kMinRungs;
  const double freedom = ladder.rungs() - (few ? 2 : 3);
  const double squares = few ? ladder.line.squares : parabola.squares;
  return students_t(freedom, 0.975) * std::sqrt(squares / freedom) * standard_error(ladder, ladder.line);
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

// The line through log e - log(1 + a h / h_0), for b = log(1 + a). Its weights are those of the ladder's line.
struct Straightened {
  double slope = 0, squares = 0;
};
Straightened with_bend(const Ladder& ladder, double b) {
  const double a = std::expm1(b);
  std::vector<double> left(ladder.y.begin(), ladder.y.end());
  Straightened line;
  double mean = 0, weights = 0;
  for (std::size_t i = 0; i < left.size(); ++i) {
    left[i] -= std::log1p(a * ladder.powers.h[i]);
    line.slope += ladder.line.weight[i] * left[i];
  }
  for (std::size_t i = 0; i < left.size(); ++i) {
    const double weight = ladder.sqrt_weight[i] * ladder.sqrt_weight[i];
    left[i] -= line.slope * (ladder.x[i] - ladder.x[0]);
    mean += weight * left[i];
    weights += weight;
  }
  for (std::size_t i = 0; i < left.size(); ++i) {
    const double residual = ladder.sqrt_weight[i] * (left[i] - mean / weights);
    line.squares += residual * residual;
  }
  return line;
}

struct Bend {
  double b = 0, squares = 0;
};
Bend best_bend(const Ladder& ladder) {
  constexpr int parts = 16, bits = 20;
  const auto squares = [&](double b) { return with_bend(ladder, b).squares; };
  const double low = std::log(kMinDeparture), high = std::log(kMaxDeparture), part = (high - low) / parts;
  Bend best{low, squares(low)};
  for (int k = 1; k <= parts; ++k)
    if (const Bend other{low + part * k, squares(low + part * k)}; other.squares < best.squares) best = other;
  const auto [b, least] =
      boost::math::tools::brent_find_minima(squares, std::max(low, best.b - part), std::min(high, best.b + part), bits);
  return {b, least};
}

// The posterior of p as a mixture of Student's t: at points on both sides of the best bend, as far as the likelihood
// counts, denser towards the best.
struct Part {
  double weight = 0, centre = 0, width = 0;
};
std::vector<Part> posterior(const Ladder& ladder, const Bend& best, double freedom) {
  constexpr int points = 12, halvings = 30;
  constexpr double negligible = 1e-4;
  const double least = std::max(best.squares, 1e-28);
  const auto likelihood = [&](double squares) { return std::pow(std::max(squares / least, 1.0), -freedom / 2); };
  std::vector<Part> parts;
  for (const double end : {std::log(kMinDeparture), std::log(kMaxDeparture)}) {
    const auto counts = [&](double u) {
      return likelihood(with_bend(ladder, best.b + u * (end - best.b)).squares) - negligible;
    };
    const double reach = (end - best.b) * (counts(1) > 0 ? 1 : bisect(counts, 0.0, 1.0, halvings).high);
    for (int k = 0; k < points; ++k) {
      const double u = (k + 0.5) / points;
      const Straightened fit = with_bend(ladder, best.b + reach * u * u);
      const double deviation = std::sqrt(std::max(fit.squares, least) / freedom);
      parts.push_back(
          {likelihood(fit.squares) * u * std::fabs(reach), fit.slope, deviation * standard_error(ladder, ladder.line)});
    }
  }
  double most = 0;
  for (const Part& p : parts) most = std::max(most, p.weight);
  std::erase_if(parts, [&](const Part& p) { return p.weight < 3e-3 * most; });
  return parts;
}

// Where the mixture is exceeded with this probability.
double upper_point(const std::vector<Part>& parts, double freedom, double probability) {
  constexpr int halvings = 18;
  constexpr double far = 30;  // widths
  double total = 0, low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Part& p : parts) {
    total += p.weight;
    low = std::min(low, p.centre - far * p.width);
    high = std::max(high, p.centre + far * p.width);
  }
  // Without boost's long double in between, which takes six times as long.
  using InDouble = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
  const boost::math::students_t_distribution<double, InDouble> student(freedom);
  const auto excess = [&](double x) {
    double sum = 0;
    for (const Part& p : parts)
      sum += p.weight / total * boost::math::cdf(complement(student, (x - p.centre) / p.width));
    return sum - probability;
  };
  return bisect(excess, low, high, halvings).high;
}

// What describes the rungs: the bend with scatter about it; another smooth deviation much better, and both intervals
// count; a smooth deviation up to the bars, or so much better that noise does not explain it. Four rungs never tell.
enum class Described { by_scatter, by_either, smoothly };
Described described(const Ladder& ladder, const Bend& best) {
  const Powers& p = ladder.powers;
  const auto beyond_bars = [&](double squares, double parameters) {
    return std::pow(std::max(std::sqrt(squares) - ladder.norm_of_bars, 0.0), 2) / (ladder.rungs() - parameters);
  };
  const double left = beyond_bars(best.squares, 3);
  double as_many = beyond_bars(ladder.with(p.root).squares, 3);
  for (const auto* column : {&p.h_squared, &p.x_squared, &p.inverse})
    as_many = std::min(as_many, beyond_bars(ladder.with(*column).squares, 3));
  if (const HalfPower half = fit_half_power(ladder); half.converged)
    as_many = std::min(as_many, beyond_bars(half.fit.squares, 3));
  double one_more = left;
  if (ladder.x.size() > kMinRungs)
    one_more = std::min(beyond_bars(ladder.with(p.h, p.h_squared).squares, 4),
                        beyond_bars(ladder.with(p.root, p.h).squares, 4));
  if (!(std::min({left, as_many, one_more}) > 0)) return Described::smoothly;
  if (ladder.x.size() > kMinRungs &&
      (as_many < left / (kCertain * kMuchBetter) || one_more < left / (kCertain * kMuchBetterByOneMore)))
    return Described::smoothly;
  return as_many < left / kMuchBetter || one_more < left / kMuchBetterByOneMore ? Described::by_either
                                                                                : Described::by_scatter;
}

}  // namespace

std::optional<OrderInterval> scatter_interval(std::span<const double> x, std::span<const double> y,
                                              std::span<const double> bar) {
  const std::size_t n = x.size();
  const auto finest = [&](std::size_t k) { return ladder_of(x.last(k), y.last(k), bar.last(k)); };
  std::size_t count = kMinRungs;
  Ladder ladder = finest(count);
  Bend best = best_bend(ladder);
  // A coarser rung belongs to the window unless it departs from the finer ones: its externally studentised residual, at
  // the 0.5 % level; of four, whose scatter has one degree of freedom, at 2.5 %.
  for (; count < n; ++count) {
    Ladder longer = finest(count + 1);
    const Bend next = best_bend(longer);
    const double freedom = static_cast<double>(count) - 3;
    const double limit = students_t(freedom, count == kMinRungs ? 0.9875 : 0.9975);
    if (next.squares - best.squares > limit * limit * best.squares / freedom) break;
    if (range_of_slopes(longer) > kMaxRange) break;
    ladder = std::move(longer);
    best = next;
  }
  const Described by = described(ladder, best);
  if (by == Described::smoothly) return std::nullopt;
  const double freedom = ladder.rungs() - 2 - kCaution;
  const std::vector<Part> parts = posterior(ladder, best, freedom);
  std::vector<double> tangent(ladder.powers.h);
  for (double& h : tangent) h /= 1 + std::expm1(best.b) * h;
  const double by_bars = uncertainty_by_bars(ladder.with(tangent).weight, ladder.bar);
  OrderInterval out;
  out.first = n - count;
  out.smooth = by == Described::by_either;
  out.finest = (y[n - 1] - y[n - 2]) / (x[n - 1] - x[n - 2]);
  out.extrapolated = with_bend(ladder, best.b).slope;
  out.range_of_slopes = range_of_slopes(ladder);
  out.settles = best.b < 0.99 * std::log(kMaxDeparture);
  const double of_finest = (bar[n - 1] + bar[n - 2] + 2 * kRoundOff) / std::fabs(x[n - 1] - x[n - 2]);
  out.low = std::min(upper_point(parts, freedom, 0.975) - by_bars, out.finest - of_finest);
  out.high = std::max(upper_point(parts, freedom, 0.025) + by_bars, out.finest + of_finest);
  return out;
}

OrderInterval order_interval(std::span<const double> x, std::span<const double> y, std::span<const double> bar) {
  const std::size_t n = x.size();
  const Ladder ladder = ladder_of(x, y, bar);
  const ColumnFit linear = ladder.with(ladder.powers.h), square = ladder.with(ladder.powers.h_squared);
  const bool monotone = slopes_monotone(x, y, ladder.bar);

  OrderInterval out;
  out.finest = (y[n - 1] - y[n - 2]) / (x[n - 1] - x[n - 2]);
  out.extrapolated = linear.last;
  out.range_of_slopes = range_of_slopes(ladder);
  const double scatter = scatter_half_width(ladder, ladder.with(ladder.powers.x_squared));
  out.low = ladder.line.last - scatter - ladder.line_uncertainty;
  out.high = ladder.line.last + scatter + ladder.line_uncertainty;
  add_models(ladder, monotone, linear, square, out);
  // Where the bars explain what the finest rungs do, the coarser ones alone do not tell.
  const bool finest_diverge =
      n == kMinRungs || diverges(ladder_of(x.last(kMinRungs), y.last(kMinRungs), bar.last(kMinRungs)));
  out.settles = !(monotone && diverges(ladder) && finest_diverge);
  return out;
}

}  // namespace atwood::metrics
