// Medians and quantiles of measured samples, and the interval that the sorted values themselves give a median.
#pragma once

#include <vector>

namespace atwood {

// A value with an interval of at least 95 %.
struct Estimate {
  double value = 0, low = 0, high = 0;
};

namespace metrics {

// The median, the mean of the two middle values of an even count; reorders x. Of none: 0.
double median_in_place(std::vector<double>& x);

// The quantile p in (0, 1] by nearest rank: the smallest value such that at least a fraction p of x does not exceed it.
// NaN of none. A 95th percentile needs 20 values: with fewer it is the largest.
double nearest_rank(std::vector<double> x, double p);
// Its index among n > 0 sorted values.
std::size_t nearest_rank_index(std::size_t n, double p);
constexpr std::size_t kMinForP95 = 20;

// The median and its interval by order statistics: the ranks of the sorted values that enclose the distribution's
// median with at least 95 %, for every distribution (sign test; David and Nagaraja, Order Statistics, section 7.1). For
// fewer than six values: their range, which contains it with probability 1 - 2^(1 - n). Without values all are NaN;
// with one value the interval is NaN.
Estimate median_interval(std::vector<double> x);

}  // namespace metrics
}  // namespace atwood
