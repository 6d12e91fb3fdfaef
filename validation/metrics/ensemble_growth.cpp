// The growth law of round-off, from an ensemble of runs perturbed in the last place.
//
// The samples of one run are a single random walk and do not show its law; the root mean square over many runs does.
// Brouwer, Astron. J. 46 (1937) 149: unbiased rounding makes the energy walk as t^1/2 and the phase, its integral, as
// t^3/2; rounding that is biased, as t and t^2.
#include <algorithm>
#include <cmath>

#include "validation/metrics/metrics.hpp"
#include "validation/metrics/quantile.hpp"
#include "validation/metrics/resample.hpp"
#include "validation/metrics/slope_fit.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMinRuns = 32, kMinSamples = 60;
constexpr int kResamples = 400;

// Slope of log root mean square over the picked runs against log t.
double exponent(std::span<const std::vector<double>> squares, std::span<const std::size_t> picked,
                std::span<const double> log_t) {
  std::vector<double> log_rms(log_t.size(), 0.0);
  for (std::size_t k : picked)
    for (std::size_t i = 0; i < log_t.size(); ++i) log_rms[i] += squares[k][i];
  for (double& v : log_rms) v = 0.5 * std::log(std::max(v, 1e-300));
  return metrics::fit_line(log_t, log_rms).slope;
}

// Degrees of freedom of a variance estimated from n values of kurtosis k (Satterthwaite):
//   2 / ((k - 3) / n + 2 / (n - 1)).
// The runs' contributions to the exponent have heavy tails, for which n - 1 is too large.
double degrees_of_freedom(std::span<const double> shares) {
  const double n = static_cast<double>(shares.size());
  double mean = 0, second = 0, fourth = 0;
  for (double s : shares) mean += s / n;
  for (double s : shares) {
    second += (s - mean) * (s - mean) / n;
    fourth += std::pow(s - mean, 4) / n;
  }
  if (!(second > 0)) return n - 1;
  return std::max(3.0, 2 / (std::max(0.0, fourth / (second * second) - 3) / n + 2 / (n - 1)));
}

}  // namespace

GrowthFit fit_growth_ensemble(std::span<const double> t_s, std::span<const std::vector<double>> runs) {
  GrowthFit fit;
  fit.law = "inconclusive";
  if (runs.size() < kMinRuns) {
    fit.reason = std::to_string(runs.size()) + " runs, a law at the floor needs " + std::to_string(kMinRuns);
    return fit;
  }
  if (t_s.size() < kMinSamples) {
    fit.reason = std::to_string(t_s.size()) + " samples, a law needs 60";
    return fit;
  }
  // Without the first tenth of the run, where the perturbation of the start still dominates.
  std::vector<double> log_t;
  std::vector<std::vector<double>> squares(runs.size());
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    const double t = t_s[i] - t_s.front();
    if (t < 0.1 * (t_s.back() - t_s.front())) continue;
    log_t.push_back(std::log(t));
    double sum = 0;
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const double e = i < runs[k].size() ? runs[k][i] : std::nan("");
      squares[k].push_back(e * e);
      sum += e * e;
    }
    if (!(sum > 0) || !std::isfinite(sum)) {
      fit.reason = sum == 0 ? "all runs agree to the last digit" : "a run is not finite";
      return fit;
    }
  }
  const std::size_t n = runs.size();
  std::vector<std::size_t> picked(n);
  for (std::size_t k = 0; k < n; ++k) picked[k] = k;
  fit.exponent = exponent(squares, picked, log_t);

  std::vector<double> shares;  // contribution of each run, by leaving it out
  for (std::size_t k = 0; k < n; ++k) {
    std::vector<std::size_t> others;
    for (std::size_t j = 0; j < n; ++j)
      if (j != k) others.push_back(j);
    shares.push_back(exponent(squares, others, log_t));
  }
  SplitMix64 random{0x42726f77};
  double mean = 0, squared = 0;
  for (int r = 0; r < kResamples; ++r) {
    for (std::size_t& k : picked) k = metrics::draw(random, n);
    const double e = exponent(squares, picked, log_t) - fit.exponent;
    mean += e / kResamples;
    squared += e * e / kResamples;
  }
  // Corrects the variance of resamples by n / (n - 1).
  const double error = std::sqrt((squared - mean * mean) * static_cast<double>(n) / static_cast<double>(n - 1));
  fit.half_width_95 = metrics::students_t(degrees_of_freedom(shares), 0.975) * error;
  name_law(fit);
  return fit;
}

}  // namespace atwood
