// Errors of a run's states relative to the true states at the same times.
#include <quadmath.h>

#include <algorithm>
#include <cmath>

#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace metrics {

double norm(const std::array<Wide, 3>& a) {
  return static_cast<double>(sqrtq(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]));
}

double distance(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  return norm({a[0] - b[0], a[1] - b[1], a[2] - b[2]});
}

bool has_truth(const Truth& truth) { return truth.outcome.status == Status::ok && !truth.values.empty(); }

namespace {

bool finite(Wide x) { return std::isfinite(static_cast<double>(x)); }

bool finite(const BodySample& b) {
  for (int i = 0; i < 3; ++i)
    if (!finite(b.p_m[i]) || !finite(b.v_m_per_s[i]) || !finite(b.w_rad_per_s[i])) return false;
  for (const Wide& c : b.q_wxyz)
    if (!finite(c)) return false;
  return true;
}

std::vector<Row> status_row(Status status, std::string reason) {
  Row r = row("status", 0, 0, std::move(reason));
  r.status = status;
  return {r};
}

enum class Quantity { position, velocity, attitude, body_rate };

double error_of(Quantity q, const BodySample& a, const BodySample& b) {
  switch (q) {
    case Quantity::position: return distance(a.p_m, b.p_m);
    case Quantity::velocity: return distance(a.v_m_per_s, b.v_m_per_s);
    case Quantity::attitude: return attitude_error_rad(a, b);
    case Quantity::body_rate: return distance(a.w_rad_per_s, b.w_rad_per_s);
  }
  return 0;
}

// The bar of an error: the norm of the components' bars; an error d of a quaternion is a rotation by 2 |d|.
double bar_of(Quantity q, const BodySample& bar) {
  switch (q) {
    case Quantity::position: return norm(bar.p_m);
    case Quantity::velocity: return norm(bar.v_m_per_s);
    case Quantity::attitude: {
      Wide sum = 0;
      for (const Wide& c : bar.q_wxyz) sum += c * c;
      return 2 * static_cast<double>(sqrtq(sum));
    }
    case Quantity::body_rate: return norm(bar.w_rad_per_s);
  }
  return 0;
}

bool applies(Quantity q, const Body& body) {
  if (body.fixed) return false;
  return q == Quantity::position || q == Quantity::velocity || rotates(body);
}

std::vector<int> measured_bodies(Quantity q, const Scene& scene) {
  std::vector<int> bodies;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (applies(q, scene.bodies[i])) bodies.push_back(static_cast<int>(i));
  return bodies;
}

double bar_at(Quantity q, const Truth& truth, std::size_t k, int body) {
  return k < truth.bars.size() ? bar_of(q, truth.bars[k].bodies[body]) : 0;
}

std::vector<double> worst_series(Quantity q, const Scenario& scenario, const Truth& truth, const Recording& run) {
  const std::vector<int> bodies = measured_bodies(q, scenario.scene);
  std::vector<double> series;
  if (bodies.empty()) return series;
  for (std::size_t k = 0; k < run.values.size() && k < truth.values.size(); ++k) {
    double worst = 0;
    for (int b : bodies) worst = std::max(worst, error_of(q, run.values[k].bodies[b], truth.values[k].bodies[b]));
    series.push_back(worst);
  }
  return series;
}

// Per body, samples whose time lies within the bar of an impact's time: whether the velocity is that before or after
// the jump is undecided. In a scene with joints or ropes an impact may change the velocity of every body.
std::vector<std::vector<std::size_t>> samples_on_impacts(const Scene& scene, const Truth& truth) {
  std::vector<std::vector<std::size_t>> on(scene.bodies.size());
  const bool all = has_mechanism(scene);
  for (std::size_t i = 0; i < truth.events.size(); ++i) {
    const Event& event = truth.events[i];
    if (event.kind != EventKind::impact) continue;
    const Wide bar = i < truth.event_bar_s.size() ? truth.event_bar_s[i] : 0;
    auto at = std::lower_bound(truth.values.begin(), truth.values.end(), event.t_s - bar,
                               [](const SampleView& s, Wide t) { return s.t_s < t; });
    for (; at != truth.values.end() && at->t_s <= event.t_s + bar; ++at)
      for (std::size_t body = 0; body < on.size(); ++body)
        if (all || static_cast<int>(body) == event.body_a || static_cast<int>(body) == event.body_b)
          on[body].push_back(static_cast<std::size_t>(at - truth.values.begin()));
  }
  for (auto& samples : on) {
    std::sort(samples.begin(), samples.end());
    samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  }
  return on;
}

// The largest of all instants, the root mean square of the judged ones.
void append_quantity(Quantity q, const std::string& name, const Scenario& scenario, const Observed& all,
                     std::vector<Row>& rows) {
  const std::vector<int> bodies = measured_bodies(q, scenario.scene);
  const Recording& run = all.run;
  const Truth& truth = all.truth;
  const std::vector<bool>& judged = all.judged;
  const std::size_t n = run.values.size();
  if (bodies.empty() || n < 2) return;
  const bool jumps = q == Quantity::velocity || q == Quantity::body_rate;
  const auto on_impacts = samples_on_impacts(scenario.scene, truth);
  Largest end, largest, rms;
  std::size_t left_out = 0;
  for (int b : bodies) {
    double squares = 0, bar_squares = 0;
    std::size_t kept = 0;
    for (std::size_t k = 1; k < n; ++k) {
      const double e = error_of(q, run.values[k].bodies[b], truth.values[k].bodies[b]);
      const double bar = bar_at(q, truth, k, b);
      if (k + 1 == n) end.take(e, bar);
      if (jumps && std::ranges::binary_search(on_impacts[b], k)) {
        ++left_out;
        continue;
      }
      largest.take(e, bar);
      if (!judged[k]) continue;
      ++kept;
      squares += e * e;
      bar_squares += bar * bar;
    }
    if (kept == 0) continue;
    rms.take(std::sqrt(squares / static_cast<double>(kept)), std::sqrt(bar_squares / static_cast<double>(kept)));
  }
  const std::string note =
      left_out == 0 ? "" : std::to_string(left_out) + " samples on the instant of an impact left out";
  rows.push_back(row("error-" + name + "-end", end.value(), end.bar()));
  if (largest.figures.empty()) return;
  rows.push_back(row("error-" + name + "-max", largest.value(), largest.bar(), note));
  rows.push_back(row("error-" + name + "-rms", rms.value(), rms.bar(), note));
}

Wide squared(const std::array<Wide, 3>& a) { return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]; }

Wide squared_difference(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  return squared({a[0] - b[0], a[1] - b[1], a[2] - b[2]});
}

// |y - y_true| / |y_true| at the last sample, y = positions and velocities of all moving bodies in one vector, as the
// literature of orbit problems reports it (Hairer, Norsett and Wanner, Solving ODEs I, section II.10).
void append_state_end(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows) {
  const std::size_t last = run.values.size() - 1;
  Wide error = 0, bar = 0, size = 0;
  for (std::size_t b = 0; b < scenario.scene.bodies.size(); ++b) {
    if (scenario.scene.bodies[b].fixed) continue;
    const BodySample& found = run.values[last].bodies[b];
    const BodySample& expected = truth.values[last].bodies[b];
    error += squared_difference(found.p_m, expected.p_m) + squared_difference(found.v_m_per_s, expected.v_m_per_s);
    size += squared(expected.p_m) + squared(expected.v_m_per_s);
    if (last < truth.bars.size())
      bar += squared(truth.bars[last].bodies[b].p_m) + squared(truth.bars[last].bodies[b].v_m_per_s);
  }
  if (!(size > 0)) return;
  rows.push_back(
      row("error-state-end", static_cast<double>(sqrtq(error / size)), static_cast<double>(sqrtq(bar / size))));
}

}  // namespace

std::vector<Row> status_rows(const Scenario& scenario, const Truth& truth, const Recording& run) {
  if (run.outcome.status != Status::ok) return status_row(run.outcome.status, run.outcome.reason);
  for (std::size_t k = 0; k < run.values.size(); ++k) {
    const SampleView& s = run.values[k];
    if (s.bodies.size() != scenario.scene.bodies.size())
      return status_row(Status::crashed, "sample " + std::to_string(k) + " has " + std::to_string(s.bodies.size()) +
                                             " bodies, the scene has " + std::to_string(scenario.scene.bodies.size()));
    for (std::size_t b = 0; b < s.bodies.size(); ++b)
      if (!finite(s.bodies[b]))
        return status_row(Status::not_finite, "body `" + scenario.scene.bodies[b].name + "` is not finite at t = " +
                                                  format_double(static_cast<double>(s.t_s)) + " s");
  }
  for (const Event& event : run.events)
    if ((event.body_a < 0 || event.body_b < 0) && stop_of(scenario.scene, event) == nullptr)
      return status_row(Status::crashed, "an event names a body that the scene has not");
  if (run.values.size() < 2) return status_row(Status::crashed, "no samples after t = 0");
  if (!has_truth(truth)) return {};
  if (run.values.size() != truth.values.size())
    return status_row(Status::crashed,
                      std::to_string(run.values.size()) + " samples, expected " + std::to_string(truth.values.size()));
  // Samples must be at the same times as the truth's; a clock in float may differ by round-off.
  for (std::size_t k = 0; k < run.values.size(); ++k)
    if (fabsq(run.values[k].t_s - truth.values[k].t_s) > Wide(1e-4) * scenario.t_end_s / Wide(truth.values.size() - 1))
      return status_row(Status::crashed, "sample " + std::to_string(k) + " is at t = " +
                                             format_double(static_cast<double>(run.values[k].t_s)) + " s, expected " +
                                             format_double(static_cast<double>(truth.values[k].t_s)) + " s");
  return {};
}

void append_state_errors(const Scenario& scenario, const Observed& all, std::vector<Row>& rows) {
  append_quantity(Quantity::position, "position", scenario, all, rows);
  append_quantity(Quantity::velocity, "velocity", scenario, all, rows);
  append_quantity(Quantity::attitude, "attitude", scenario, all, rows);
  append_quantity(Quantity::body_rate, "body-rate", scenario, all, rows);
  append_state_end(scenario, all.truth, all.run, rows);
}

void append_norm_drift(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  constexpr double least = 1e-6;  // above the round-off of normalising in float
  double largest = 0;
  for (const SampleView sample : run.values)
    for (std::size_t b = 0; b < sample.bodies.size(); ++b) {
      if (!applies(Quantity::attitude, scenario.scene.bodies[b])) continue;
      const auto& [w, x, y, z] = sample.bodies[b].q_wxyz;
      largest = std::max(largest, static_cast<double>(fabsq(sqrtq(w * w + x * x + y * y + z * z) - 1)));
    }
  if (largest > least) rows.push_back(row("quaternion-norm-drift", largest));
}

void append_sizes(const Scenario& scenario, const Truth& truth, std::vector<Row>& rows) {
  double p = 0, v = 0, w = 0;
  for (const SampleView s : truth.values)
    for (std::size_t b = 0; b < s.bodies.size(); ++b) {
      if (scenario.scene.bodies[b].fixed) continue;
      p = std::max(p, norm(s.bodies[b].p_m));
      v = std::max(v, norm(s.bodies[b].v_m_per_s));
      if (rotates(scenario.scene.bodies[b])) w = std::max(w, norm(s.bodies[b].w_rad_per_s));
    }
  rows.push_back(row("size-position", p));
  rows.push_back(row("size-velocity", v));
  if (!measured_bodies(Quantity::body_rate, scenario.scene).empty()) rows.push_back(row("size-body-rate", w));
}

}  // namespace metrics

double position_error_m(const BodySample& a, const BodySample& truth) { return metrics::distance(a.p_m, truth.p_m); }

// The relative rotation conj(truth) * a = (c, s): its angle is 2 atan2(|s|, |c|), accurate near 0 where acos(|c|)
// loses half the digits, and independent of the signs and norms of the quaternions.
double attitude_error_rad(const BodySample& a, const BodySample& truth) {
  const auto& [aw, ax, ay, az] = a.q_wxyz;
  const auto& [tw, tx, ty, tz] = truth.q_wxyz;
  const Wide c = tw * aw + tx * ax + ty * ay + tz * az;
  const Wide x = tw * ax - tx * aw - ty * az + tz * ay;
  const Wide y = tw * ay - ty * aw - tz * ax + tx * az;
  const Wide z = tw * az - tz * aw - tx * ay + ty * ax;
  const double s = static_cast<double>(sqrtq(x * x + y * y + z * z));
  return 2 * std::atan2(s, static_cast<double>(fabsq(c)));
}

namespace metrics {
namespace {

Series series_of(const Scenario& scenario, const Truth& truth, const Recording& run, const EnergyScale& scale) {
  Series series;
  for (const SampleView s : run.values) series.t_s.push_back(static_cast<double>(s.t_s));
  if (has_truth(truth)) {
    series.position_m = worst_series(Quantity::position, scenario, truth, run);
    series.velocity_m_per_s = worst_series(Quantity::velocity, scenario, truth, run);
    series.attitude_rad = worst_series(Quantity::attitude, scenario, truth, run);
    series.body_rate_rad_per_s = worst_series(Quantity::body_rate, scenario, truth, run);
  }
  series.energy = energy_change(scenario, run, scale);
  return series;
}

}  // namespace

Series judged_series(const Scenario& scenario, const Truth& truth, const Observed& all) {
  Series series = series_of(scenario, all.truth, all.run, energy_scale(scenario, truth));
  for (auto* values : {&series.t_s, &series.position_m, &series.velocity_m_per_s, &series.attitude_rad,
                       &series.body_rate_rad_per_s, &series.energy}) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < values->size(); ++k)
      if (all.judged[k]) (*values)[kept++] = (*values)[k];
    values->resize(kept);
  }
  return series;
}

}  // namespace metrics

Series error_series(const Scenario& scenario, const Truth& truth, const Recording& run) {
  using namespace metrics;
  if (!status_rows(scenario, truth, run).empty()) return {};
  return series_of(scenario, truth, run, energy_scale(scenario, truth));
}

}  // namespace atwood
