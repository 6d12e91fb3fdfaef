#include "validation/metrics/slope_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "validation/metrics/bisection.hpp"
#include "validation/metrics/quantile.hpp"

namespace atwood::metrics {
namespace {

constexpr std::size_t kPairsFrom = 400;
constexpr int kRhos = 24, kNoises = 24;
constexpr double kMinRho = -0.5, kMaxRho = 0.99, kMinNoise = 0.1;
constexpr double kPriorWalk = 0.75;  // of noise that has a walk in it

double mean_of(std::span<const double> x) {
  return std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
}

struct Candidate {
  double log_weight = 0, slope_error = 0;
};

// One rho and one variance of the white noise, in units of that of e: Kalman's filter whitens the series and both
// columns of the line.
Candidate at(double rho, double noise, std::span<const double> centred, double spread, std::span<const double> y) {
  const std::size_t n = y.size();
  double a00 = 0, a01 = 0, a11 = 0, b0 = 0, b1 = 0, c = 0, log_determinant = 0;
  const double first = rho < 1 ? 1 / (1 - rho * rho) : 1;  // of a walk the line's level takes the start
  double variance = first, mean_one = 0, mean_x = 0, mean_y = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double predicted = variance + noise, gain = variance / predicted;
    const double one = 1 - mean_one, x = centred[i] - mean_x, v = y[i] - mean_y;
    a00 += one * one / predicted;
    a01 += one * x / predicted;
    a11 += x * x / predicted;
    b0 += one * v / predicted;
    b1 += x * v / predicted;
    c += v * v / predicted;
    log_determinant += std::log(predicted);
    mean_one = rho * (mean_one + gain * one);
    mean_x = rho * (mean_x + gain * x);
    mean_y = rho * (mean_y + gain * v);
    variance = rho * rho * variance * (1 - gain) + 1;
  }
  const double determinant = a00 * a11 - a01 * a01;
  const double slope = (a00 * b1 - a01 * b0) / determinant, level = (a11 * b0 - a01 * b1) / determinant;
  const double squares = std::max(c - level * b0 - slope * b1, 1e-30 * c);
  const double freedom = static_cast<double>(n) - 2;
  double of_slope = 0, after = 0;  // after: sum over j > i of a_j rho^(j-i-1)
  for (std::size_t i = n; i-- > 0;) {
    const double a = centred[i] / spread;
    after = a + rho * after;
    of_slope += (i > 0 ? 1 : first) * after * after + noise * a * a;
  }
  return {-0.5 * log_determinant - 0.5 * std::log(determinant) - 0.5 * freedom * std::log(squares),
          std::sqrt(squares / freedom * of_slope)};
}

}  // namespace

Line fit_line(std::span<const double> x, std::span<const double> y) {
  Line line;
  const double n = static_cast<double>(x.size());
  const double mean_x = mean_of(x), mean_y = mean_of(y);
  double sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sxx += (x[i] - mean_x) * (x[i] - mean_x);
    sxy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  line.slope = sxy / sxx;
  line.intercept = mean_y - line.slope * mean_x;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double r = y[i] - line.intercept - line.slope * x[i];
    line.residual_squares += r * r;
  }
  if (x.size() < 3) return line;
  line.standard_error = std::sqrt(line.residual_squares / (n - 2) / sxx);
  line.half_width_95 = students_t(n - 2, 0.975) * line.standard_error;
  return line;
}

double theil_sen(std::span<const double> x, std::span<const double> y) {
  const std::size_t stride = std::max<std::size_t>(1, x.size() / kPairsFrom);
  std::vector<double> slopes;
  for (std::size_t i = 0; i < x.size(); i += stride)
    for (std::size_t j = i + stride; j < x.size(); j += stride)
      if (x[j] > x[i]) slopes.push_back((y[j] - y[i]) / (x[j] - x[i]));
  return median_in_place(slopes);
}

double correlated_half_width(std::span<const double> x, std::span<const double> residual, double efficiency) {
  if (x.size() < 4) return 0;
  const double mean = mean_of(x);
  std::vector<double> centred(x.begin(), x.end());
  double spread = 0;
  for (double& v : centred) {
    v -= mean;
    spread += v * v;
  }
  if (!(spread > 0) || std::all_of(residual.begin(), residual.end(), [](double r) { return r == 0; })) return 0;
  std::vector<Candidate> candidates;
  double best = -1e300, widest = 0;
  const double n = static_cast<double>(x.size());
  const auto add = [&](double rho, double noise, double share) {
    candidates.push_back(at(rho, noise, centred, spread, residual));
    candidates.back().log_weight += std::log(share);
  };
  for (int g = 0; g < kRhos; ++g) add(kMinRho + (kMaxRho - kMinRho) * (g + 0.5) / kRhos, 0, (1 - kPriorWalk) / kRhos);
  for (int g = 0; g < kNoises; ++g)
    add(1, kMinNoise * std::pow(n * n / kMinNoise, g / (kNoises - 1.0)), kPriorWalk / kNoises);
  for (const Candidate& candidate : candidates) best = std::max(best, candidate.log_weight);
  double total = 0;
  for (Candidate& c : candidates) {
    c.log_weight = std::exp(c.log_weight - best);  // from here on the weight, not its logarithm
    total += c.log_weight;
  }
  std::erase_if(candidates, [&](const Candidate& c) { return c.log_weight < 1e-6 * total; });
  for (const Candidate& c : candidates) widest = std::max(widest, c.slope_error);
  const double freedom = n - 2;
  const auto above_5_percent = [&](double half) {
    double outside = 0;
    for (const Candidate& c : candidates)
      outside += c.log_weight / total * 2 * students_t_above(freedom, half / c.slope_error);
    return outside > 0.05 ? 1 : 0;
  };
  const Bracket<double> half_width = bisect(above_5_percent, 0.0, widest * students_t(freedom, 0.9875), 20);
  if (!half_width.converged) return std::numeric_limits<double>::infinity();
  return half_width.high / std::sqrt(efficiency);
}

bool stationary(std::span<const double> residual) {
  const std::size_t n = residual.size();
  if (n < 10) return true;
  double aa = 0, ab = 0, bb = 0, ay = 0, by = 0, yy = 0;
  for (std::size_t i = 2; i < n; ++i) {
    const double level = residual[i - 1], before = residual[i - 1] - residual[i - 2], y = residual[i] - residual[i - 1];
    aa += level * level;
    ab += level * before;
    bb += before * before;
    ay += level * y;
    by += before * y;
    yy += y * y;
  }
  const double determinant = aa * bb - ab * ab;
  if (!(determinant > 1e-12 * aa * bb)) return true;  // the residuals are zero or constant
  const double phi = (bb * ay - ab * by) / determinant, gamma = (aa * by - ab * ay) / determinant;
  const double freedom = static_cast<double>(n) - 2 - 4;  // two parameters of the line, and phi and gamma
  const double variance = std::max(yy - phi * ay - gamma * by, 0.0) / freedom;
  const double count = static_cast<double>(n) - 2, critical = -3.4126 - 4.039 / count - 17.83 / (count * count);
  // phi + gamma >= 1: both roots of z^2 - (1 + phi + gamma) z + gamma are 1 or more, as of a curve that bends away.
  return phi < 0 && phi + gamma < 1 && phi * phi * determinant > critical * critical * variance * bb;
}

}  // namespace atwood::metrics
