// Drift told apart from oscillation: a robust slope, its interval corrected for autocorrelation, the residual's range.
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <optional>

#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace {

constexpr std::size_t kPairsFrom = 500;  // of longer series, about this many samples make the pairs

double median(std::vector<double> x) {
  if (x.empty()) return 0;
  const std::size_t half = x.size() / 2;
  std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(half), x.end());
  const double upper = x[half];
  if (x.size() % 2 == 1) return upper;
  return (upper + *std::max_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(half))) / 2;
}

// Theil 1950, Sen 1968: the median of the slopes of all pairs.
double theil_sen(std::span<const double> t, std::span<const double> v) {
  const std::size_t stride = std::max<std::size_t>(1, t.size() / kPairsFrom);
  std::vector<double> slopes;
  for (std::size_t i = 0; i < t.size(); i += stride)
    for (std::size_t j = i + stride; j < t.size(); j += stride)
      if (t[j] > t[i]) slopes.push_back((v[j] - v[i]) / (t[j] - t[i]));
  return median(std::move(slopes));
}

std::vector<double> residual(std::span<const double> t, std::span<const double> v, double slope) {
  std::vector<double> r(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) r[i] = v[i] - slope * t[i];
  const double level = median(r);
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
      crossings.push_back(i == 0 ? t[i] : t[i - 1] + (middle + band - r[i - 1]) / (r[i] - r[i - 1]) * (t[i] - t[i - 1]));
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

double interpolate(std::span<const double> t, std::span<const double> v, double at) {
  const auto upper = std::upper_bound(t.begin(), t.end(), at);
  const std::size_t j = std::clamp<std::size_t>(static_cast<std::size_t>(upper - t.begin()), 1, t.size() - 1);
  const double s = (at - t[j - 1]) / (t[j] - t[j - 1]);
  return v[j - 1] + s * (v[j] - v[j - 1]);
}

// Values whole periods apart differ by the drift alone, whatever the shape of the oscillation.
double whole_period_slope(std::span<const double> t, std::span<const double> v, double period_s) {
  const double lag = period_s * std::max(1.0, std::floor((t.back() - t.front()) / period_s / 2));
  std::vector<double> slopes;
  for (std::size_t i = 0; i < t.size() && t[i] + lag <= t.back(); ++i)
    slopes.push_back((interpolate(t, v, t[i] + lag) - v[i]) / lag);
  return median(std::move(slopes));
}

// Standard error of a slope, residuals correlated from one sample to the next by rho: n (1 - rho) / (1 + rho) of them
// are worth as much as independent ones (Bartlett 1935), rho corrected for its bias in short series (Kendall 1954).
double half_width(std::span<const double> t, const std::vector<double>& r, double efficiency) {
  const double n = static_cast<double>(r.size());
  double squares = 0, lagged = 0, mean_t = 0, spread_t = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    squares += r[i] * r[i];
    if (i > 0) lagged += r[i] * r[i - 1];
    mean_t += t[i] / n;
  }
  for (double x : t) spread_t += (x - mean_t) * (x - mean_t);
  if (!(squares > 0) || !(spread_t > 0)) return 0;
  double rho = lagged / squares;
  rho = std::clamp(rho + (1 + 4 * rho) / n, 0.0, 0.999);
  const double independent = std::clamp(n * (1 - rho) / (1 + rho), 3.0, n);
  const double variance = squares / (n - 2) * n / independent;
  const double quantile = boost::math::quantile(boost::math::students_t(independent - 2), 0.975);
  return quantile * std::sqrt(variance / spread_t / efficiency);
}

}  // namespace

DriftFit fit_drift(std::span<const double> t_s, std::span<const double> value) {
  DriftFit fit;
  for (double v : value) fit.largest = std::max(fit.largest, std::fabs(v));
  if (t_s.size() < 4) return fit;
  fit.slope_per_s = theil_sen(t_s, value);
  double efficiency = 0.91;  // of Theil-Sen beside least squares, Gaussian residuals
  std::vector<double> r = residual(t_s, value, fit.slope_per_s);
  // A slope that is off shifts the crossings and with them the period: the pair is found by iteration.
  for (int pass = 0; pass < 4; ++pass) {
    const auto period_s = period(t_s, r);
    if (!period_s) break;
    fit.slope_per_s = whole_period_slope(t_s, value, *period_s);
    efficiency = 0.48;  // pairs half a run apart: 12/16 of least squares; their median: 2/pi of that
    r = residual(t_s, value, fit.slope_per_s);
  }
  const auto [low, high] = std::minmax_element(r.begin(), r.end());
  fit.oscillation = (*high - *low) / 2;
  fit.half_width_95 = half_width(t_s, r, efficiency);
  return fit;
}

}  // namespace atwood
