// The law by which an error grows: a power of t or an exponential, fitted to its envelope.
#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

constexpr std::size_t kFewestSamples = 60;
constexpr std::size_t kWindows = 12;

struct Line { double slope = 0, half_width = 0, residual = 0; };

Line fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  const double n = static_cast<double>(x.size());
  double mean_x = 0, mean_y = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) { mean_x += x[i] / n; mean_y += y[i] / n; }
  for (std::size_t i = 0; i < x.size(); ++i) {
    sxx += (x[i] - mean_x) * (x[i] - mean_x);
    sxy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  Line line;
  line.slope = sxy / sxx;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double r = y[i] - mean_y - line.slope * (x[i] - mean_x);
    line.residual += r * r;
  }
  line.half_width = boost::math::quantile(boost::math::students_t(n - 2), 0.975) * std::sqrt(line.residual / (n - 2) / sxx);
  return line;
}

// The largest error of each of 12 equal windows of time, the first tenth of the run left out: what oscillates within a
// window drops out, and the points are nearly independent where neighbouring samples are not.
struct Envelope { std::vector<double> t, e; };
Envelope envelope(std::span<const double> t, std::span<const double> e) {
  Envelope env;
  const double start = t.front() + 0.1 * (t.back() - t.front()), width = (t.back() - start) / kWindows;
  for (std::size_t w = 0; w < kWindows; ++w) {
    const double from = start + static_cast<double>(w) * width, to = from + width * (1 + 1e-9);
    double largest = 0, at = 0;
    for (std::size_t i = 0; i < t.size(); ++i)
      if (t[i] > from && t[i] <= to && e[i] > largest) { largest = e[i]; at = t[i]; }
    if (largest > 0) { env.t.push_back(at - t.front()); env.e.push_back(largest); }
  }
  return env;
}

}  // namespace

GrowthFit fit_growth(std::span<const double> t_s, std::span<const double> error, double floor) {
  GrowthFit fit;
  fit.law = "inconclusive";
  if (t_s.size() < kFewestSamples || error.size() != t_s.size()) {
    fit.reason = std::to_string(t_s.size()) + " samples, a law needs 60";
    return fit;
  }
  for (double e : error)
    if (!std::isfinite(e)) { fit.reason = "the error is not finite"; return fit; }
  const Envelope env = envelope(t_s, error);
  if (env.e.size() < kWindows) {
    fit.reason = "the error vanishes in parts of the run";
    return fit;
  }
  std::vector<double> sorted = env.e;
  std::sort(sorted.begin(), sorted.end());
  if (sorted[sorted.size() / 2] < 30 * floor) {
    fit.reason = "within 30 x the floor: a law there needs an ensemble of runs";
    return fit;
  }
  std::vector<double> log_t, log_e;
  for (std::size_t i = 0; i < env.t.size(); ++i) {
    log_t.push_back(std::log(env.t[i]));
    log_e.push_back(std::log(env.e[i]));
  }
  const Line power = fit_line(log_t, log_e), exponential = fit_line(env.t, log_e);
  fit.exponent = power.slope;
  fit.half_width_95 = power.half_width;
  const double grown = exponential.slope * (env.t.back() - env.t.front());
  if (exponential.residual < 0.5 * power.residual && grown > 3 && power.slope > 2.2) {
    fit.law = "exponential";
    fit.reason = "rate " + format_double(exponential.slope) + " 1/s";
    return fit;
  }
  struct Law { const char* name; double exponent; };
  constexpr std::array<Law, 5> laws{{{"bounded", 0}, {"t^1/2", 0.5}, {"t", 1}, {"t^3/2", 1.5}, {"t^2", 2}}};
  const auto nearest = std::min_element(laws.begin(), laws.end(), [&](const Law& a, const Law& b) {
    return std::fabs(a.exponent - fit.exponent) < std::fabs(b.exponent - fit.exponent);
  });
  if (std::fabs(nearest->exponent - fit.exponent) <= 0.2 && fit.half_width_95 <= 0.2) fit.law = nearest->name;
  else fit.reason = "exponent " + format_measure(fit.exponent, 0) + " +/- " + format_measure(fit.half_width_95, 0) + ", near no law";
  return fit;
}

namespace metrics {

void append_growth(const Series& series, double truth_bar_m, std::vector<Row>& rows) {
  const auto append = [&](const std::string& metric, const std::vector<double>& error, double floor) {
    if (error.size() < kFewestSamples) return;
    const GrowthFit fit = fit_growth(series.t_s, error, floor);
    const bool conclusive = fit.law != "inconclusive";
    std::string reason = conclusive ? fit.law : "inconclusive: " + fit.reason;
    if (conclusive && !fit.reason.empty()) reason += ", " + fit.reason;
    rows.push_back(row(metric, conclusive ? fit.exponent : std::nan(""), conclusive ? fit.half_width_95 : 0, reason));
  };
  append("growth-exponent-position", series.position_m, truth_bar_m);
  append("growth-exponent-attitude", series.attitude_rad, 0x1p-53);
  std::vector<double> energy = series.energy;
  for (double& e : energy) e = std::fabs(e);
  append("growth-exponent-energy", energy, 0x1p-53);
}

}  // namespace metrics
}  // namespace atwood
