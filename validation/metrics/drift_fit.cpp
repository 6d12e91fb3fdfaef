// Separates drift from oscillation: a robust slope, its interval corrected for autocorrelation, the residual's range.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "validation/metrics/least_squares.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/metrics/quantile.hpp"
#include "validation/metrics/resample.hpp"
#include "validation/metrics/slope_fit.hpp"

namespace atwood {
namespace {

constexpr std::size_t kTestable = 10;  // fewer samples do not show whether they are stationary: a walk's interval

constexpr double kEfficiency =
    0.95;  // of Theil-Sen beside least squares: 0.91 of white residuals, more of correlated ones

std::vector<double> residual(std::span<const double> t, std::span<const double> v, double slope) {
  std::vector<double> r(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) r[i] = v[i] - slope * t[i];
  std::vector<double> sorted = r;
  const double level = metrics::median_in_place(sorted);
  for (double& x : r) x -= level;
  return r;
}

// The period of an oscillation, from its upward crossings of mid-range (with a quarter of the range of hysteresis, so
// that noise at the crossing counts once): at least three, evenly spaced to a tenth.
std::optional<double> period(std::span<const double> t, const std::vector<double>& r) {
  const auto [low, high] = std::minmax_element(r.begin(), r.end());
  const double middle = (*low + *high) / 2, band = (*high - *low) / 4;
  std::vector<double> crossings;
  bool below = false;
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (r[i] < middle - band) below = true;
    if (below && r[i] > middle + band) {
      crossings.push_back(i == 0 ? t[i]
                                 : t[i - 1] + (middle + band - r[i - 1]) / (r[i] - r[i - 1]) * (t[i] - t[i - 1]));
      below = false;
    }
  }
  if (crossings.size() < 3) return std::nullopt;
  const double mean = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  const double spacing = (t.back() - t.front()) / static_cast<double>(t.size() - 1);
  if (mean < 4 * spacing) return std::nullopt;
  for (std::size_t i = 1; i < crossings.size(); ++i)
    if (std::fabs(crossings[i] - crossings[i - 1] - mean) > 0.1 * mean + spacing) return std::nullopt;
  return mean;
}

// v = a + b t + sum over k <= K of (c_k cos k w t + s_k sin k w t) by least squares, w = 2 pi / period: the slope
// of the drift under an oscillation of any shape, also over a fraction of a period.
struct Harmonic {
  double slope = 0, squares = 0;
  int parameters = 0;
  std::vector<double> residual;
};
Harmonic fit_harmonics(std::span<const double> t, std::span<const double> v, double period_s) {
  const std::size_t n = t.size();
  const double spacing = (t.back() - t.front()) / static_cast<double>(n - 1);
  const int harmonics =
      std::clamp(static_cast<int>(std::min(period_s / spacing / 2 - 1, (static_cast<double>(n) - 4) / 6)), 1, 10);
  const int m = 2 + 2 * harmonics;
  const auto column = [&](int c, std::size_t i) {
    if (c == 0) return 1.0;
    if (c == m - 1) return t[i] - t.front();
    const double angle = 6.283185307179586 * ((c + 1) / 2) * (t[i] - t.front()) / period_s;
    return c % 2 == 1 ? std::cos(angle) : std::sin(angle);
  };
  // Time comes last, so its coefficient is the slope.
  std::vector<std::vector<double>> columns(static_cast<std::size_t>(m), std::vector<double>(n));
  for (int c = 0; c < m; ++c)
    for (std::size_t i = 0; i < n; ++i) columns[static_cast<std::size_t>(c)][i] = column(c, i);
  metrics::ColumnFit of_columns = metrics::fit_columns(columns, v);
  return {std::isnan(of_columns.last) ? 0 : of_columns.last, of_columns.squares, m, std::move(of_columns.residual)};
}

// The period that leaves the least residual, within a quarter of a turn over the whole run of the crossings' estimate:
// golden section.
double refined_period(std::span<const double> t, std::span<const double> v, double period_s) {
  const double half_width = 0.25 * period_s * period_s / (t.back() - t.front());
  double low = period_s - half_width, high = period_s + half_width;
  constexpr double golden = 0.618033988749895;
  double a = high - golden * (high - low), b = low + golden * (high - low);
  double at_a = fit_harmonics(t, v, a).squares, at_b = fit_harmonics(t, v, b).squares;
  for (int pass = 0; pass < 18; ++pass) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - golden * (high - low);
      at_a = fit_harmonics(t, v, a).squares;
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + golden * (high - low);
      at_b = fit_harmonics(t, v, b).squares;
    }
  }
  return (low + high) / 2;
}

// The mean slope of a series whose slope changes, with Student's interval over the mean slopes of at most eight equal
// parts: of a random walk they are independent draws. It is a quarter wider, because 1 of 17 random walks passes for
// stationary and then has too narrow an interval: 95 % are for both together; not where too few samples are tested. Of
// fewer parts than four it is infinite.
void fit_parts(std::span<const double> t, const std::vector<double>& v, DriftFit& fit) {
  const std::size_t intervals = t.size() - 1, parts = std::min<std::size_t>(8, intervals);
  std::vector<double> slopes;
  for (std::size_t k = 0; k < parts; ++k) {
    const std::size_t from = k * intervals / parts, to = (k + 1) * intervals / parts;
    slopes.push_back((v[to] - v[from]) / (t[to] - t[from]));
  }
  const double count = static_cast<double>(parts);
  fit.slope_per_s = (v.back() - v.front()) / (t.back() - t.front());
  fit.one_sign = parts == 8 && (std::ranges::all_of(slopes, [](double x) { return x > 0; }) ||
                                std::ranges::all_of(slopes, [](double x) { return x < 0; }));
  double squares = 0;
  for (const double slope : slopes) squares += (slope - fit.slope_per_s) * (slope - fit.slope_per_s);
  if (parts >= 4)
    fit.half_width_95 = (t.size() < kTestable ? 1 : 1.25) * metrics::students_t(count - 1, 0.975) *
                        std::sqrt(squares / (count - 1) / count);
}

}  // namespace

DriftFit fit_drift(std::span<const double> t_s, std::span<const double> value) {
  DriftFit fit;
  for (double v : value) fit.largest = std::max(fit.largest, std::fabs(v));
  if (t_s.size() < 4) return fit;
  fit.slope_per_s = metrics::theil_sen(t_s, value);
  std::vector<double> r = residual(t_s, value, fit.slope_per_s), noise = r;
  double width_scale = 1, known = 0;
  // A wrong slope shifts the crossings and so the period; slope and period are found by at most three
  // passes, which is the method.
  for (int pass = 0; pass < 3; ++pass) {
    const auto crossing = period(t_s, r);
    if (!crossing || std::fabs(*crossing - known) < 1e-3 * known) break;
    known = *crossing;
    fit.period_s = refined_period(t_s, value, *crossing);
    const Harmonic under = fit_harmonics(t_s, value, fit.period_s);
    fit.slope_per_s = under.slope + metrics::theil_sen(t_s, under.residual);
    noise = residual(t_s, under.residual, fit.slope_per_s - under.slope);
    const double n = static_cast<double>(t_s.size());
    width_scale = std::sqrt((n - 2) / (n - under.parameters));
    r = residual(t_s, value, fit.slope_per_s);
  }
  fit.stationary = t_s.size() >= kTestable && metrics::stationary(noise);
  if (fit.stationary) {
    // 5 % wider: series that pass the test for stationarity tend to have an underestimated correlation.
    fit.half_width_95 = 1.05 * width_scale * metrics::correlated_half_width(t_s, noise, kEfficiency);
  } else {
    fit.half_width_95 = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < noise.size(); ++i) noise[i] += fit.slope_per_s * t_s[i];  // without the oscillation
    fit_parts(t_s, noise, fit);
    r = residual(t_s, value, fit.slope_per_s);
  }
  const auto [low, high] = std::minmax_element(r.begin(), r.end());
  fit.oscillation = (*high - *low) / 2;
  return fit;
}

EnsembleDrift fit_drift_ensemble(std::span<const double> t_s, std::span<const std::vector<double>> runs) {
  constexpr std::size_t min_runs = 32;
  constexpr int resamples = 1000;
  EnsembleDrift drift;
  const std::size_t n = runs.size();
  if (n < min_runs) {
    drift.reason = std::to_string(n) + " runs, a drift at the floor needs " + std::to_string(min_runs);
    return drift;
  }
  std::vector<double> slopes;
  for (const std::vector<double>& run : runs) {
    if (run.size() != t_s.size() || run.size() < 2) {
      drift.reason = "a run has other samples";
      return drift;
    }
    slopes.push_back(metrics::fit_line(t_s, run).slope);
    if (!std::isfinite(slopes.back())) {
      drift.reason = "a run is not finite";
      return drift;
    }
  }
  const auto mean_of = [](const std::vector<double>& x) {
    double sum = 0;
    for (double v : x) sum += v;
    return sum / static_cast<double>(x.size());
  };
  drift.slope_per_s = mean_of(slopes);
  SplitMix64 random{0x6472696674};
  std::vector<double> resample(n);
  double squares = 0;
  for (int r = 0; r < resamples; ++r) {
    for (double& s : resample) s = slopes[metrics::draw(random, n)];
    const double off = mean_of(resample) - drift.slope_per_s;
    squares += off * off / resamples;
  }
  // Corrects the variance of resamples by n / (n - 1).
  const double count = static_cast<double>(n), error = std::sqrt(squares * count / (count - 1));
  drift.half_width_95 = metrics::students_t(count - 1, 0.975) * error;
  return drift;
}

}  // namespace atwood
