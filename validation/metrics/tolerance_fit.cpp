// Tolerance calibration: how an adaptive method's error depends on its tolerance.
#include <algorithm>
#include <cmath>
#include <vector>

#include "validation/metrics/metrics.hpp"
#include "validation/metrics/slope_fit.hpp"

namespace atwood {

ToleranceFit fit_tolerance(std::span<const double> rtol, std::span<const double> error, std::span<const double> floor) {
  constexpr double floor_factor = 30;
  constexpr std::size_t min_rungs = 4;
  ToleranceFit fit;
  std::vector<double> x, y;
  for (std::size_t i = 0; i < rtol.size(); ++i) {
    const double f = i < floor.size() ? floor[i] : 0;
    if (!(rtol[i] > 0) || !std::isfinite(error[i]) || !(error[i] > floor_factor * f) || !(error[i] > 0)) continue;
    x.push_back(std::log10(rtol[i]));
    y.push_back(std::log10(error[i]));
  }
  fit.used = static_cast<int>(x.size());
  if (x.size() < min_rungs) {
    fit.reason = std::to_string(x.size()) + " of " + std::to_string(rtol.size()) +
                 " tolerances lie above 30 x the floor; a slope needs 4";
    return fit;
  }
  if (*std::max_element(x.begin(), x.end()) - *std::min_element(x.begin(), x.end()) < 1) {
    fit.reason = "the tolerances span less than a decade";
    return fit;
  }
  const metrics::Line line = metrics::fit_line(x, y);
  fit.conclusive = true;
  fit.exponent = line.slope;
  fit.half_width_95 = line.half_width_95;
  return fit;
}

}  // namespace atwood
