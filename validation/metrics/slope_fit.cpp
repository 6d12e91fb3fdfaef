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
constexpr int kGrid = 24;
constexpr double kMinRho = -0.5, kMaxRho = 0.99;

double mean_of(std::span<const double> x) {
  return std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
}

struct Candidate {
  double log_weight = 0, slope_error = 0;
};

// One rho: y_i - rho y_(i-1) is white; the first sample enters with weight sqrt(1 - rho^2).
Candidate at_rho(double rho, std::span<const double> centred, double spread, std::span<const double> y) {
  const std::size_t n = y.size();
  double a00 = 0, a01 = 0, a11 = 0, b0 = 0, b1 = 0, c = 0;
  const auto add = [&](double one, double x, double v) {
    a00 += one * one;
    a01 += one * x;
    a11 += x * x;
    b0 += one * v;
    b1 += x * v;
    c += v * v;
  };
  const double first = std::sqrt(1 - rho * rho);
  add(first, first * centred[0], first * y[0]);
  for (std::size_t i = 1; i < n; ++i) add(1 - rho, centred[i] - rho * centred[i - 1], y[i] - rho * y[i - 1]);
  const double determinant = a00 * a11 - a01 * a01;
  const double slope = (a00 * b1 - a01 * b0) / determinant, level = (a11 * b0 - a01 * b1) / determinant;
  const double squares = std::max(c - level * b0 - slope * b1, 1e-30 * c);
  const double freedom = static_cast<double>(n) - 2;
  double variance = 0, before = 0;  // before: sum over j < i of a_j rho^(i-j-1)
  for (double x : centred) {
    const double a = x / spread;
    variance += a * a + 2 * a * before * rho;
    before = before * rho + a;
  }
  return {0.5 * std::log(1 - rho * rho) - 0.5 * std::log(determinant) - 0.5 * freedom * std::log(squares),
          std::sqrt(squares / freedom / (1 - rho * rho) * variance)};
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
  for (int g = 0; g < kGrid; ++g) {
    const double rho = kMinRho + (kMaxRho - kMinRho) * (g + 0.5) / kGrid;
    candidates.push_back(at_rho(rho, centred, spread, residual));
    best = std::max(best, candidates.back().log_weight);
  }
  double total = 0;
  for (Candidate& c : candidates) {
    c.log_weight = std::exp(c.log_weight - best);  // from here on the weight, not its logarithm
    total += c.log_weight;
  }
  std::erase_if(candidates, [&](const Candidate& c) { return c.log_weight < 1e-6 * total; });
  for (const Candidate& c : candidates) widest = std::max(widest, c.slope_error);
  const double freedom = static_cast<double>(x.size()) - 2;
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
