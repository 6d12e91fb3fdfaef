#include "validation/metrics/order_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace atwood::metrics {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// The largest k with P(Binomial(n, 1/2) < k) <= 0.025: the k-th smallest and the k-th largest of n enclose their
// median.
std::size_t outer_rank(std::size_t n) {
  double term = std::pow(0.5, static_cast<double>(n)), below = 0;
  std::size_t k = 0;
  while (k < n && below + term <= 0.025) {
    below += term;
    term *= static_cast<double>(n - k) / static_cast<double>(k + 1);
    ++k;
  }
  return k;
}

}  // namespace

double median_in_place(std::vector<double>& x) {
  if (x.empty()) return 0;
  const auto half = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), half, x.end());
  if (x.size() % 2 == 1) return *half;
  return (*std::max_element(x.begin(), half) + *half) / 2;
}

double nearest_rank(std::vector<double> x, double p) {
  if (x.empty()) return kNone;
  std::sort(x.begin(), x.end());
  return x[nearest_rank_index(x.size(), p)];
}

std::size_t nearest_rank_index(std::size_t n, double p) {
  constexpr double round_off = 1e-12;  // 0.95 * 20 is 19, not a little more
  const double rank = std::ceil(p * static_cast<double>(n) * (1 - round_off));
  return std::clamp<std::size_t>(static_cast<std::size_t>(rank), 1, n) - 1;
}

Estimate median_interval(std::vector<double> x) {
  if (x.empty()) return {kNone, kNone, kNone};
  const double middle = median_in_place(x);
  if (x.size() == 1) return {middle, kNone, kNone};
  std::sort(x.begin(), x.end());
  const std::size_t rank = std::max<std::size_t>(1, outer_rank(x.size()));
  return {middle, x[rank - 1], x[x.size() - rank]};
}

}  // namespace atwood::metrics
