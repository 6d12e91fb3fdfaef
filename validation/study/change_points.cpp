#include "validation/study/change_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "validation/metrics/order_statistics.hpp"

namespace atwood {
namespace {

// Differences below this are none: the tolerance of a baseline for our own engine, whose figures repeat exactly.
constexpr double kMinSpread = 1e-3;
constexpr double kPenalty = 4;
constexpr std::size_t kShortest = 2;  // runs of a segment

double spread_of(const std::vector<double>& x) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < x.size(); ++i) steps.push_back(std::fabs(x[i] - x[i - 1]));
  return std::max(kMinSpread, metrics::median_in_place(steps) / (0.6745 * std::sqrt(2.0)));
}

}  // namespace

ChangePoints find_change_points(std::span<const double> values) {
  ChangePoints found;
  const std::size_t n = values.size();
  found.enough = n >= kMinRuns && std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
  if (!found.enough) return found;
  found.logarithmic = std::all_of(values.begin(), values.end(), [](double x) { return x > 0; });
  double largest = 0;
  for (const double x : values) largest = std::max(largest, std::fabs(x));
  if (largest == 0) return found;
  std::vector<double> x;
  for (const double value : values) x.push_back(found.logarithmic ? std::log(value) : value / largest);
  found.spread = spread_of(x);
  found.penalty = kPenalty * found.spread * found.spread * std::log(static_cast<double>(n));

  // Sums from the first value, which is subtracted: levels far from zero lose no digits.
  std::vector<double> sum(n + 1), squares(n + 1);
  for (std::size_t i = 0; i < n; ++i) {
    const double d = x[i] - x[0];
    sum[i + 1] = sum[i] + d;
    squares[i + 1] = squares[i] + d * d;
  }
  const auto cost = [&](std::size_t from, std::size_t to) {
    const double s = sum[to] - sum[from];
    return squares[to] - squares[from] - s * s / static_cast<double>(to - from);
  };
  // best[t]: the least of the first t values; last[t]: where its last segment begins.
  std::vector<double> best(n + 1, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> last(n + 1, 0);
  best[0] = -found.penalty;
  for (std::size_t to = kShortest; to <= n; ++to)
    for (std::size_t from = 0; from + kShortest <= to; ++from)
      if (const double total = best[from] + cost(from, to) + found.penalty; total < best[to]) {
        best[to] = total;
        last[to] = from;
      }
  for (std::size_t at = last[n]; at > 0; at = last[at]) found.starts.push_back(at);
  std::reverse(found.starts.begin(), found.starts.end());
  return found;
}

}  // namespace atwood
