// The law by which an error grows: a power of t or an exponential, fitted to its envelope.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "validation/metrics/least_squares.hpp"
#include "validation/metrics/measurements.hpp"
#include "validation/metrics/quantile.hpp"
#include "validation/metrics/slope_fit.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMinFitSamples = 60;
constexpr std::size_t kWindows = 12;
// One law holds where its interval lies within kOneLaw of it and no significant bend changes the exponent by more
// than kExponentChange along the run. For a t + b t^2 both limits are near b t_end / a = 0.2 and 50: there one term is
// a fifth of the other, at the end of the run or at the beginning of the envelope, and the exponent is off by 0.1.
constexpr double kExponentChange = 0.1, kOneLaw = 0.12;
// An offset up to this share of the growth over the run is beside it.
constexpr double kMaxOffset = 0.25;
// An error whose whole interval is nearer to 0 than to 1/2 is bounded.
constexpr double kBounded = 0.25;

// The largest error of each of 12 equal windows of time, without the first tenth of the run: oscillations within a
// window are removed, and the points are nearly independent although neighbouring samples are not. The largest relative
// to t^exponent: otherwise the last samples of a window would always be chosen where the error grows.
struct Envelope {
  std::vector<double> t, e;
};
Envelope envelope(std::span<const double> t, std::span<const double> e, double exponent) {
  Envelope env;
  const double start = t.front() + 0.1 * (t.back() - t.front()), width = (t.back() - start) / kWindows;
  for (std::size_t w = 0; w < kWindows; ++w) {
    const double from = start + static_cast<double>(w) * width, to = from + width * (1 + 1e-9);
    double largest = 0;
    std::size_t at = t.size();
    for (std::size_t i = 0; i < t.size(); ++i) {
      if (!(t[i] > from) || !(t[i] <= to) || !(e[i] > 0)) continue;
      const double beside = e[i] * std::pow((t[i] - t.front()) / (t.back() - t.front()), -exponent);
      if (beside > largest) {
        largest = beside;
        at = i;
      }
    }
    if (at < t.size()) {
      env.t.push_back(t[at] - t.front());
      env.e.push_back(e[at]);
    }
  }
  return env;
}

std::vector<double> logarithms(std::vector<double> x) {
  for (double& v : x) v = std::log(v);
  return x;
}

// Local exponents of the first and the last window by a parabola through the logarithms of the envelope, and whether
// its curvature is significant at the 5 % level.
struct Bend {
  double first = 0, last = 0;
  bool significant = false;
};
Bend bend_of(std::span<const double> x, std::span<const double> y, const metrics::Line& line) {
  const std::size_t n = x.size();
  std::vector<double> squares(n);
  for (std::size_t i = 0; i < n; ++i) squares[i] = (x[i] - x[0]) * (x[i] - x[0]);
  const metrics::Line of_squares = metrics::fit_line(x, squares);
  double along = 0, norm = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double bend = squares[i] - of_squares.intercept - of_squares.slope * x[i];
    along += bend * (y[i] - line.intercept - line.slope * x[i]);
    norm += bend * bend;
  }
  const double c = along / norm, freedom = static_cast<double>(n) - 3;
  const double left = std::max(line.residual_squares - along * c, 0.0);
  const double limit = metrics::students_t(freedom, 0.975);
  const auto slope_at = [&](double at) { return line.slope + c * (2 * (at - x[0]) - of_squares.slope); };
  return {slope_at(x[0]), slope_at(x[n - 1]), c * c * norm > limit * limit * left / freedom};
}

// Whether the residuals of the law are not stationary: a single random walk then looks like a power. The law is that of
// the envelope: a line is removed from the residuals, which lie below it.
bool wanders(std::span<const double> t, std::span<const double> e, const metrics::Line& law) {
  std::vector<double> at, left;
  double squares = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double from = t[i] - t.front();
    if (from < 0.1 * (t.back() - t.front()) || !(e[i] > 0)) continue;
    // Limits the weight of an error that passes near zero.
    left.push_back(std::max(std::log(e[i]) - law.intercept - law.slope * std::log(from), -3.0));
    at.push_back(t[i]);
  }
  const metrics::Line line = metrics::fit_line(at, left);
  for (std::size_t i = 0; i < left.size(); ++i) {
    left[i] -= line.intercept + line.slope * at[i];
    squares += left[i] * left[i];
  }
  return squares > 0.01 * static_cast<double>(left.size()) && !metrics::stationary(left);
}

// The rate of an exponential from a line in the logarithms. An error e^{kt} - 1, or of two exponentials, bends at the
// beginning: the interval contains the rate extrapolated to late times as well, by
// log e = c + k t + a e^{-k t / 2} with the line's k in the last term, enlarged by Roache's safety factor (as
// order_interval.hpp does for h).
struct Rate {
  double value = 0, half_width = 0;
};
Rate exponential_rate(const std::vector<double>& t, const std::vector<double>& log_e, const metrics::Line& line) {
  constexpr double safety = 1.25;
  std::vector<double> one(t.size(), 1), decay(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) decay[i] = std::exp(-line.slope * t[i] / 2);
  const metrics::ColumnFit late = metrics::fit_columns({one, decay, t}, log_e);
  double weights = 0;
  for (const double w : late.weight) weights += w * w;
  const double freedom = static_cast<double>(t.size()) - 3,
               scatter = metrics::students_t(freedom, 0.975) * std::sqrt(late.squares / freedom * weights),
               at = line.slope + safety * (late.last - line.slope);
  const double low = std::min(line.slope - line.half_width_95, at - scatter),
               high = std::max(line.slope + line.half_width_95, at + scatter);
  return {(low + high) / 2, (high - low) / 2};
}

// Mean errors of 12 equal windows of the whole run, at mean times in units of the run, with the roots of their weights:
// the inverse variances of the means, from the differences of neighbouring samples in a window and the two windows on
// either side of it. None where a window has fewer than three samples.
struct Means {
  std::vector<double> t, e, root;
};
std::optional<Means> window_means(std::span<const double> t, std::span<const double> e) {
  std::vector<double> count(kWindows, 0.0), differences(kWindows, 0.0);
  Means means{count, count, count};
  const double run = t.back() - t.front();
  const auto window = [&](std::size_t i) {
    const auto w = static_cast<std::size_t>((t[i] - t.front()) / run * static_cast<double>(kWindows));
    return std::min(w, kWindows - 1);
  };
  for (std::size_t i = 1; i < t.size(); ++i) {
    const std::size_t w = window(i);
    count[w] += 1;
    means.t[w] += (t[i] - t.front()) / run;
    means.e[w] += e[i];
    if (i > 1 && window(i - 1) == w) differences[w] += (e[i] - e[i - 1]) * (e[i] - e[i - 1]);
  }
  if (*std::min_element(count.begin(), count.end()) < 3) return std::nullopt;
  double largest = 0, mean_variance = 0;
  for (std::size_t w = 0; w < kWindows; ++w) {
    means.t[w] /= count[w];
    means.e[w] /= count[w];
    differences[w] /= count[w] - 1;
    largest = std::max(largest, means.e[w]);
    mean_variance += differences[w] / static_cast<double>(kWindows);
  }
  for (std::size_t w = 0; w < kWindows; ++w) {
    const std::size_t from = w < 2 ? 0 : w - 2, to = std::min(kWindows, w + 3);
    double near = 0;
    for (std::size_t v = from; v < to; ++v) near += differences[v] / static_cast<double>(to - from);
    // A window in which neighbours hardly differ is not known that much better.
    means.root[w] = largest / std::sqrt(near + 0.1 * mean_variance + 1e-12 * largest * largest);
  }
  return means;
}

// Growth beside an offset: the means are c + a t^p. An oscillation that is added to a growing error averages out in a
// window, and c is what it leaves, as where it begins at one of its zeros; in the logarithms of the envelope both bend
// a straight line. p is that of least squares; its 95 % interval are all p whose squares are below 1 + t^2 / freedom
// times the least (Bates and Watts 1988, 6.1).
struct BesideOffset {
  double exponent = 0, half_width_95 = std::numeric_limits<double>::infinity();
  double share = 0;  // |c / a|
};
BesideOffset growth_beside_offset(const Means& means) {
  constexpr double step = 0.02;
  constexpr int steps = 150;
  const std::vector<double> one(kWindows, 1.0);
  const auto power = [&](double p) {
    std::vector<double> x = means.t;
    for (double& v : x) v = std::pow(v, p);
    return x;
  };
  std::vector<double> squares;
  for (int k = 1; k <= steps; ++k)
    squares.push_back(metrics::fit_columns({one, power(step * k)}, means.e, means.root).squares);
  const auto least = std::min_element(squares.begin(), squares.end());
  const double freedom = static_cast<double>(kWindows) - 3, limit = metrics::students_t(freedom, 0.975);
  const auto within = [&](double s) { return s <= *least * (1 + limit * limit / freedom); };
  const auto first = std::find_if(squares.begin(), squares.end(), within);
  const auto last = std::find_if(squares.rbegin(), squares.rend(), within).base() - 1;
  const double low = step * static_cast<double>(first - squares.begin() + 1),
               high = step * static_cast<double>(last - squares.begin() + 1);
  const std::vector<double> best = power(step * static_cast<double>(least - squares.begin() + 1));
  const double offset = metrics::fit_columns({best, one}, means.e, means.root).last,
               growth = metrics::fit_columns({one, best}, means.e, means.root).last;
  return {(low + high) / 2, (high - low) / 2 + step, std::fabs(offset / growth)};
}

// Whether the error grows as t beside an offset. Only t: a sum a t + b t^2 is near c + d t^(3/2).
bool linear_beside_offset(std::span<const double> t, std::span<const double> e, GrowthFit& fit) {
  const std::optional<Means> means = window_means(t, e);
  if (!means) return false;
  const BesideOffset found = growth_beside_offset(*means);
  if (!(found.share <= kMaxOffset)) return false;
  GrowthFit named = fit;
  named.exponent = found.exponent;
  named.half_width_95 = found.half_width_95;
  name_law(named, kOneLaw);
  if (named.law != "t") return false;
  fit = named;
  fit.reason = "beside an offset";
  return true;
}

}  // namespace

GrowthFit fit_growth(std::span<const double> t_s, std::span<const double> error, double floor) {
  GrowthFit fit;
  fit.law = "inconclusive";
  if (t_s.size() < kMinFitSamples || error.size() != t_s.size()) {
    fit.reason = std::to_string(t_s.size()) + " samples, a law needs 60";
    return fit;
  }
  for (double e : error)
    if (!std::isfinite(e)) {
      fit.reason = "the error is not finite";
      return fit;
    }
  Envelope env = envelope(t_s, error, 0);
  if (env.e.size() < kWindows) {
    fit.reason = "the error vanishes in parts of the run";
    return fit;
  }
  std::vector<double> sorted = env.e;
  std::sort(sorted.begin(), sorted.end());
  if (sorted[sorted.size() / 2] < 30 * floor) {
    fit.reason = "round-off: within 30 x the floor, where a law needs an ensemble of runs";
    return fit;
  }
  for (int pass = 0; pass < 4; ++pass) {  // a fixed number, which is the method
    fit.exponent = metrics::fit_line(logarithms(env.t), logarithms(env.e)).slope;
    env = envelope(t_s, error, fit.exponent);
  }
  const std::vector<double> log_t = logarithms(env.t), log_e = logarithms(env.e);
  const metrics::Line power = metrics::fit_line(log_t, log_e), exponential = metrics::fit_line(env.t, log_e);
  fit.exponent = power.slope;
  fit.half_width_95 = power.half_width_95;
  const double grown = exponential.slope * (env.t.back() - env.t.front());
  if (exponential.residual_squares < 0.5 * power.residual_squares && grown > 3 && power.slope > 2.2) {
    fit.law = "exponential";
    const Rate rate = exponential_rate(env.t, log_e, exponential);
    fit.rate_per_s = rate.value;
    fit.rate_half_width_95 = rate.half_width;
    fit.reason = "rate " + format_measure(rate.value, 0) + " +/- " + format_measure(rate.half_width, 0, 2) + " 1/s";
    return fit;
  }
  const Bend bend = bend_of(log_t, log_e, power);
  if (bend.significant && std::fabs(bend.last - bend.first) > kExponentChange) {
    if (linear_beside_offset(t_s, error, fit)) return fit;
    fit.reason = "no power of t: the exponent goes from " + format_measure(bend.first, 0) + " to " +
                 format_measure(bend.last, 0) + " along the run";
    return fit;
  }
  if (wanders(t_s, error, power)) {
    fit.reason = "what the law leaves is not stationary, as of one draw of a walk: a law needs an ensemble of runs";
    return fit;
  }
  name_law(fit, kOneLaw);
  if (fit.law == "inconclusive") linear_beside_offset(t_s, error, fit);
  return fit;
}

void name_law(GrowthFit& fit, double whole_within) {
  struct Law {
    const char* name;
    double exponent;
  };
  constexpr std::array<Law, 5> laws{{{"bounded", 0}, {"t^1/2", 0.5}, {"t", 1}, {"t^3/2", 1.5}, {"t^2", 2}}};
  const auto nearest = std::min_element(laws.begin(), laws.end(), [&](const Law& a, const Law& b) {
    return std::fabs(a.exponent - fit.exponent) < std::fabs(b.exponent - fit.exponent);
  });
  const double off = std::fabs(nearest->exponent - fit.exponent);
  if (nearest->exponent == 0) whole_within = std::max(whole_within, kBounded);
  fit.law = "inconclusive";
  // The next law is 0.5 away: an interval of +- 0.2 whose centre is off by at most 0.2 does not reach it.
  if (off <= 0.2 && fit.half_width_95 <= 0.2 && off + fit.half_width_95 <= whole_within) {
    fit.law = nearest->name;
    return;
  }
  const bool near = off <= std::min(0.2, whole_within);
  fit.reason = "exponent " + format_measure(fit.exponent, 0) + " +/- " + format_measure(fit.half_width_95, 0, 2) +
               (near                             ? ": too wide for a law"
                : fit.half_width_95 < 0.25 - off ? ": no single law, as of a sum of powers"
                                                 : ", near no law");
}

namespace metrics {

void append_growth(const Series& series, const GrowthFloors& floors, std::vector<Row>& rows) {
  const auto append = [&](const std::string& metric, const std::vector<double>& error, double floor) {
    if (error.size() < kMinFitSamples) return;
    const GrowthFit fit = fit_growth(series.t_s, error, floor);
    const bool conclusive = fit.law != "inconclusive";
    std::string reason = conclusive ? fit.law : "inconclusive: " + fit.reason;
    if (conclusive && !fit.reason.empty()) reason += ", " + fit.reason;
    rows.push_back(row(metric, conclusive ? fit.exponent : std::nan(""), conclusive ? fit.half_width_95 : 0, reason));
  };
  append("growth-exponent-position", series.position_m, floors.position_m);
  append("growth-exponent-attitude", series.attitude_rad, floors.attitude_rad);
  std::vector<double> energy = series.energy;
  for (double& e : energy) e = std::fabs(e);
  append("growth-exponent-energy", energy, floors.energy);
}

}  // namespace metrics
}  // namespace atwood
