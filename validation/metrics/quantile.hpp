// Quantiles of samples and of Student's t. Private to this room.
#pragma once

#include <cstddef>
#include <vector>

#include "validation/metrics/order_statistics.hpp"

namespace atwood::metrics {

// The value at p (n - 1) of ascending x, p in [0, 1], between neighbours linearly (definition 7 of Hyndman and Fan, The
// American Statistician 50 (1996) 361). Of none: 0.
double quantile(const std::vector<double>& ascending, double p);

// What a variate of Student's t with `freedom` > 0 degrees of freedom stays below with probability p in (0, 1).
double students_t(double freedom, double p);
// The probability that it exceeds x.
double students_t_above(double freedom, double x);

}  // namespace atwood::metrics
