// The largest Lyapunov exponent from stretches of a run and a twin, whose distance is reset after each stretch.
//
// Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980) 9: the mean of ln(d_end / d_start) / T over stretches
// of length T, each starting where the last ended, along the separation it ended with. Neighbouring stretches are
// correlated, so the interval comes from the means of ten long blocks of them.
//
// Motion without an exponent separates too: neighbouring orbits linearly in time, where their periods differ. The rates
// p / t of a power t^p are positive and fall, and their mean over a finite run is no exponent. An exponent is resolved
// where the whole interval stands for more e-foldings than t^2 would make; a test for a trend of the block means is not
// enough, since oscillations hide it in short runs.
#include <algorithm>
#include <cmath>
#include <vector>

#include "validation/metrics/metrics.hpp"
#include "validation/metrics/quantile.hpp"

namespace atwood {
namespace {

constexpr double kPower = 2;  // of time, the fastest separation without an exponent that is considered

}  // namespace

LyapunovFit fit_lyapunov(std::span<const double> local_exponents, double stretch_s) {
  constexpr std::size_t min_exponents = 8, max_blocks = 10;
  LyapunovFit fit;
  // In the first stretches the separation turns to the direction of fastest growth: a tenth, at least one, is left out.
  const std::size_t skipped = std::max<std::size_t>(1, local_exponents.size() / 10);
  if (local_exponents.size() < skipped + min_exponents) return fit;
  const auto used = local_exponents.subspan(skipped);
  const double n = static_cast<double>(used.size());
  double mean = 0;
  for (double x : used) mean += x / n;
  // Batch means (Law and Carson 1979): ten long blocks are nearly independent also if stretches are correlated.
  const std::size_t count = std::min(max_blocks, used.size() / 2);
  std::vector<double> block_means;
  for (std::size_t b = 0; b < count; ++b) {
    const std::size_t from = b * used.size() / count, to = (b + 1) * used.size() / count;
    double sum = 0;
    for (std::size_t i = from; i < to; ++i) sum += used[i];
    block_means.push_back(sum / static_cast<double>(to - from));
  }
  const double m = static_cast<double>(count);
  double squares = 0;
  for (double x : block_means) squares += (x - mean) * (x - mean);
  fit.exponent_per_s = mean;
  fit.half_width_95 = metrics::students_t(m - 1, 0.975) * std::sqrt(squares / (m - 1) / m);
  fit.stretches = static_cast<int>(used.size());
  const double used_s = stretch_s * n;
  fit.e_foldings = mean * used_s;
  // From the end of the first tenth to the end of the run.
  fit.e_foldings_of_power = kPower * std::log((used_s + stretch_s * static_cast<double>(skipped)) /
                                              (stretch_s * static_cast<double>(skipped)));
  const double least = std::fabs(mean) - fit.half_width_95;
  fit.resolved = least <= 0 || least * used_s > fit.e_foldings_of_power;
  return fit;
}

}  // namespace atwood
