// Resampling: draws with replacement, and the middle 95 % (Efron and Tibshirani, An Introduction to the
// Bootstrap, 1993, ch. 13). Private to this room.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "scene/split_mix.hpp"
#include "validation/metrics/quantile.hpp"

namespace atwood::metrics {

// Uniform in 0 .. n - 1.
inline std::size_t draw(SplitMix64& random, std::size_t n) {
  return std::min(n - 1, static_cast<std::size_t>(random.next_unit() * static_cast<double>(n)));
}

// A standard normal deviate (Box and Muller 1958).
inline double draw_normal(SplitMix64& random) {
  const double u = 1 - random.next_unit(), angle = 6.283185307179586 * random.next_unit();
  return std::sqrt(-2 * std::log(u)) * std::cos(angle);
}

// The 2.5 and 97.5 percentiles, interpolated linearly; reorders x. Both 0 where x is empty.
struct Interval {
  double low = 0, high = 0;
};
inline Interval percentiles_95(std::vector<double>& x) {
  std::sort(x.begin(), x.end());
  return {quantile(x, 0.025), quantile(x, 0.975)};
}

}  // namespace atwood::metrics
