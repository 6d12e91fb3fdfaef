// The growth of a step's time with the number of bodies.
#include <cmath>

#include "validation/metrics/metrics.hpp"
#include "validation/metrics/slope_fit.hpp"

namespace atwood {

// The exponent is the slope of log T on log N. For comparison with N log N also the slope of log (T / log N), which is
// 1 where T is proportional to N log N.
ScalingFit fit_scaling(std::span<const double> bodies, std::span<const double> seconds) {
  ScalingFit fit;
  std::vector<double> x, y, y_over_log;
  for (std::size_t i = 0; i < bodies.size() && i < seconds.size(); ++i) {
    if (!(bodies[i] > 1) || !(seconds[i] > 0) || !std::isfinite(seconds[i])) continue;
    x.push_back(std::log(bodies[i]));
    y.push_back(std::log(seconds[i]));
    y_over_log.push_back(std::log(seconds[i] / std::log(bodies[i])));
  }
  fit.rungs = static_cast<int>(x.size());
  if (fit.rungs < 4) return fit;
  const metrics::Line power = metrics::fit_line(x, y), over_log = metrics::fit_line(x, y_over_log);
  fit.exponent = power.slope;
  fit.half_width_95 = power.half_width_95;
  fit.exponent_over_log = over_log.slope;
  fit.half_width_over_log_95 = over_log.half_width_95;
  return fit;
}

}  // namespace atwood
