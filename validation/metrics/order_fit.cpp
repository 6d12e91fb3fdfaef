// Observed order: least squares of log error on log h over the asymptotic window, which the data choose.
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>
#include <string>

#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace {

constexpr double kFloorFactor = 30;    // rungs nearer than this to the floor measure the floor too
constexpr double kSlopeChange = 0.2;   // asymptotic: the local slope has settled to this
constexpr std::size_t kFewest = 4;

// The longest run of rungs, ending at the finest, whose local slopes all lie within kSlopeChange of each other. It always
// ends at the finest rung above the floor: no rung is left out because the error stopped falling there, so an error that
// grows as h shrinks shows its negative order.
std::size_t first_asymptotic(const std::vector<double>& log_h, const std::vector<double>& log_e) {
  const std::size_t n = log_h.size();
  const auto slope = [&](std::size_t i) { return (log_e[i + 1] - log_e[i]) / (log_h[i + 1] - log_h[i]); };
  std::size_t first = n - 2;
  double least = slope(first), most = least;
  while (first > 0) {
    least = std::min(least, slope(first - 1));
    most = std::max(most, slope(first - 1));
    if (most - least > kSlopeChange) break;
    --first;
  }
  return first;
}

// y = a + b x: b and its 95 % half-width, n - 2 degrees of freedom.
void fit_line(const std::vector<double>& x, const std::vector<double>& y, double& slope, double& half_width) {
  const double n = static_cast<double>(x.size());
  const double mean_x = std::accumulate(x.begin(), x.end(), 0.0) / n;
  const double mean_y = std::accumulate(y.begin(), y.end(), 0.0) / n;
  double sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sxx += (x[i] - mean_x) * (x[i] - mean_x);
    sxy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  slope = sxy / sxx;
  double residual = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double r = y[i] - mean_y - slope * (x[i] - mean_x);
    residual += r * r;
  }
  const double t = boost::math::quantile(boost::math::students_t(n - 2), 0.975);
  half_width = t * std::sqrt(residual / (n - 2) / sxx);
}

}  // namespace

OrderFit fit_order(std::span<const double> h_s, std::span<const double> error, std::span<const double> floor) {
  OrderFit fit;
  fit.left_out.assign(h_s.size(), "");
  std::vector<int> rungs(h_s.size());
  std::iota(rungs.begin(), rungs.end(), 0);
  std::stable_sort(rungs.begin(), rungs.end(), [&](int a, int b) { return h_s[a] > h_s[b]; });

  std::vector<int> kept;
  for (int i : rungs) {
    const double f = static_cast<std::size_t>(i) < floor.size() ? floor[i] : 0;
    if (!std::isfinite(error[i]) || !(h_s[i] > 0)) fit.left_out[i] = "not finite";
    else if (!(error[i] > 0) || !(error[i] > kFloorFactor * f)) fit.left_out[i] = "floor";
    // Only what is finer than the last failure is one ladder: a rung between two that blew up proves nothing.
    if (fit.left_out[i] == "not finite") {
      for (int k : kept) fit.left_out[k] = "pre-asymptotic";
      kept.clear();
    } else if (fit.left_out[i].empty()) {
      kept.push_back(i);
    }
  }
  if (kept.size() < kFewest) {
    fit.reason = std::to_string(kept.size()) + " of " + std::to_string(rungs.size()) +
                 " rungs lie above 30 x the floor; an order needs " + std::to_string(kFewest);
    return fit;
  }

  std::vector<double> log_h, log_e;
  for (int i : kept) {
    log_h.push_back(std::log(h_s[i]));
    log_e.push_back(std::log(error[i]));
  }
  const std::size_t first = first_asymptotic(log_h, log_e);
  for (std::size_t k = 0; k < first; ++k) fit.left_out[kept[k]] = "pre-asymptotic";
  fit.used.assign(kept.begin() + static_cast<std::ptrdiff_t>(first), kept.end());
  if (fit.used.size() < kFewest) {
    fit.reason = "local slopes still change by more than 0.2 at the finest rungs: " + std::to_string(fit.used.size()) +
                 " rungs in the window, an order needs " + std::to_string(kFewest);
    return fit;
  }
  log_h.erase(log_h.begin(), log_h.begin() + static_cast<std::ptrdiff_t>(first));
  log_e.erase(log_e.begin(), log_e.begin() + static_cast<std::ptrdiff_t>(first));
  fit_line(log_h, log_e, fit.order, fit.half_width_95);
  fit.conclusive = true;
  return fit;
}

}  // namespace atwood
