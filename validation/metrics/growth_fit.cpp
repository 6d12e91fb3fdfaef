// The law by which an error grows: a power of t or an exponential, fitted to its envelope.
#include <algorithm>
#include <array>
#include <cmath>

#include "validation/metrics/measurements.hpp"
#include "validation/metrics/slope_fit.hpp"

namespace atwood {
namespace {

constexpr std::size_t kFewestSamples = 60;
constexpr std::size_t kWindows = 12;

// The largest error of each of 12 equal windows of time, the first tenth of the run left out: what oscillates within a
// window drops out, and the points are nearly independent where neighbouring samples are not. Largest beside
// t^exponent: of a growing error the late samples of a window would win whatever their noise.
struct Envelope { std::vector<double> t, e; };
Envelope envelope(std::span<const double> t, std::span<const double> e, double exponent) {
  Envelope env;
  const double start = t.front() + 0.1 * (t.back() - t.front()), width = (t.back() - start) / kWindows;
  for (std::size_t w = 0; w < kWindows; ++w) {
    const double from = start + static_cast<double>(w) * width, to = from + width * (1 + 1e-9);
    double largest = 0;
    std::size_t at = t.size();
    for (std::size_t i = 0; i < t.size(); ++i) {
      if (!(t[i] > from) || !(t[i] <= to) || !(e[i] > 0)) continue;
      const double beside = e[i] * std::pow((t[i] - t.front()) / (t.back() - t.front()), -exponent);
      if (beside > largest) { largest = beside; at = i; }
    }
    if (at < t.size()) { env.t.push_back(t[at] - t.front()); env.e.push_back(e[at]); }
  }
  return env;
}

std::vector<double> logarithms(std::vector<double> x) {
  for (double& v : x) v = std::log(v);
  return x;
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
  Envelope env = envelope(t_s, error, 0);
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
  for (int pass = 0; pass < 4; ++pass) {
    fit.exponent = metrics::fit_line(logarithms(env.t), logarithms(env.e)).slope;
    env = envelope(t_s, error, fit.exponent);
  }
  const std::vector<double> log_t = logarithms(env.t), log_e = logarithms(env.e);
  const metrics::Line power = metrics::fit_line(log_t, log_e), exponential = metrics::fit_line(env.t, log_e);
  fit.exponent = power.slope;
  fit.half_width_95 = power.half_width_95;
  const double grown = exponential.slope * (env.t.back() - env.t.front());
  if (exponential.residual_squares < 0.5 * power.residual_squares && grown > 3 && power.slope > 2.2) {
    fit.law = "exponential";
    fit.reason = "rate " + format_measure(exponential.slope, 0) + " +/- " +
                 format_measure(exponential.half_width_95, 0, 2) + " 1/s";
    return fit;
  }
  name_law(fit);
  return fit;
}

void name_law(GrowthFit& fit) {
  struct Law { const char* name; double exponent; };
  constexpr std::array<Law, 5> laws{{{"bounded", 0}, {"t^1/2", 0.5}, {"t", 1}, {"t^3/2", 1.5}, {"t^2", 2}}};
  const auto nearest = std::min_element(laws.begin(), laws.end(), [&](const Law& a, const Law& b) {
    return std::fabs(a.exponent - fit.exponent) < std::fabs(b.exponent - fit.exponent);
  });
  const double off = std::fabs(nearest->exponent - fit.exponent);
  fit.law = "inconclusive";
  // The next law is half a unit further: an interval of 0.2 to either side, 0.2 off at most, does not reach it.
  if (off <= 0.2 && fit.half_width_95 <= 0.2) { fit.law = nearest->name; return; }
  fit.reason = "exponent " + format_measure(fit.exponent, 0) + " +/- " + format_measure(fit.half_width_95, 0, 2) +
               (off <= 0.2 ? ": too wide for a law" : ", near no law");
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
