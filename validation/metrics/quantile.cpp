#include "validation/metrics/quantile.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>

namespace atwood::metrics {

double quantile(const std::vector<double>& ascending, double p) {
  if (ascending.empty()) return 0;
  const std::size_t last = ascending.size() - 1;
  const double place = p * static_cast<double>(last);
  const std::size_t i = std::min(static_cast<std::size_t>(place), last), j = std::min(i + 1, last);
  return ascending[i] + (place - static_cast<double>(i)) * (ascending[j] - ascending[i]);
}

double students_t(double freedom, double p) { return boost::math::quantile(boost::math::students_t(freedom), p); }

double students_t_above(double freedom, double x) {
  return boost::math::cdf(complement(boost::math::students_t(freedom), x));
}

}  // namespace atwood::metrics
