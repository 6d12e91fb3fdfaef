// Ratios of timings taken in pairs A B A B: load that slows both halves of a pair cancels.
#include <algorithm>
#include <cmath>
#include <vector>

#include "scene/split_mix.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/metrics/quantile.hpp"
#include "validation/metrics/resample.hpp"

namespace atwood {

PairedRatio paired_ratio(std::span<const double> a, std::span<const double> b) {
  PairedRatio result;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    if (std::isfinite(a[i] / b[i]) && b[i] > 0) ratios.push_back(a[i] / b[i]);
  result.pairs = static_cast<int>(ratios.size());
  if (ratios.empty()) return result;
  std::vector<double> work = ratios;
  result.ratio = metrics::median_in_place(work);
  const auto [least, most] = std::minmax_element(ratios.begin(), ratios.end());
  result.low = *least;
  result.high = *most;
  // With fewer pairs the resampled median has too few values for an interval; the range contains the median with
  // probability 1 - 2^(1-n), 97 % for six.
  constexpr int min_pairs = 9;
  if (result.pairs < min_pairs) return result;
  constexpr int resamples = 2000;
  SplitMix64 random{0x70616972};
  std::vector<double> medians(resamples);
  for (double& median : medians) {
    for (double& r : work) r = ratios[metrics::draw(random, ratios.size())];
    median = metrics::median_in_place(work);
  }
  const metrics::Interval interval = metrics::percentiles_95(medians);
  result.low = interval.low;
  result.high = interval.high;
  return result;
}

}  // namespace atwood
