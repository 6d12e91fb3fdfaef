#include "validation/metrics/overhead.hpp"

#include <algorithm>
#include <cmath>

#include "validation/metrics/quantile.hpp"

namespace atwood {
namespace {

struct TimeLine {
  double at_zero = 0, slope = 0;
};

// Weighted least squares of y over x.
TimeLine line_through(std::span<const int> x, std::span<const double> y) {
  double w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double weight = 1 / (y[i] * y[i]), at = x[i];
    w += weight;
    wx += weight * at;
    wy += weight * y[i];
    wxx += weight * at * at;
    wxy += weight * at * y[i];
  }
  const double slope = (w * wxy - wx * wy) / (w * wxx - wx * wx);
  return {(wy - slope * wx) / w, slope};
}

}  // namespace

OverheadFit fit_overhead(std::span<const int> repeats, const std::vector<std::vector<double>>& ns) {
  OverheadFit fit;
  std::vector<double> overheads, rates, bends;
  const std::size_t half = repeats.size() / 2;
  for (const std::vector<double>& round : ns) {
    const bool usable = round.size() == repeats.size() &&
                        std::all_of(round.begin(), round.end(), [](double t) { return std::isfinite(t) && t > 0; });
    if (!usable) continue;
    const TimeLine line = line_through(repeats, round);
    if (!std::isfinite(line.at_zero) || !std::isfinite(line.slope)) continue;
    overheads.push_back(line.at_zero);
    rates.push_back(line.slope);
    if (repeats.size() < 4) continue;
    const TimeLine first = line_through(repeats.first(half), std::span(round).first(half));
    const TimeLine last = line_through(repeats.subspan(half), std::span(round).subspan(half));
    bends.push_back(last.slope / first.slope);
  }
  fit.rounds = static_cast<int>(overheads.size());
  if (fit.rounds == 0) return fit;
  fit.overhead_ns = metrics::median_interval(overheads);
  fit.rate_ns = metrics::median_interval(rates);
  fit.possible = fit.overhead_ns.high >= 0;
  if (bends.size() < 6) return fit;
  const Estimate bend = metrics::median_interval(bends);
  fit.straight = !((bend.low > 1 && bend.value > 1.1) || (bend.high < 1 && bend.value < 0.9));
  return fit;
}

}  // namespace atwood
