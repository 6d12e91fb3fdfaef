// Quantiles of samples and of Student's t. Private to this room.
#pragma once

#include <cstddef>
#include <vector>

#include "validation/metrics/order_statistics.hpp"

namespace atwood::metrics {

// The value at position p (n - 1) of ascending x, p in [0, 1], interpolated linearly (definition 7 of Hyndman and Fan,
// The American Statistician 50 (1996) 361). 0 where x is empty.
double quantile(const std::vector<double>& ascending, double p);

// The quantile p in (0, 1) of Student's t with `freedom` > 0 degrees of freedom.
double students_t(double freedom, double p);
// The probability that such a variate exceeds x.
double students_t_above(double freedom, double x);

}  // namespace atwood::metrics
