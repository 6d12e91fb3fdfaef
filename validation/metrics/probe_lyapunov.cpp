// Chaos: the predictability horizon, and the rate at which neighbouring runs separate.
#include <algorithm>
#include <cmath>

#include "protocol/method.hpp"
#include "scene/split_mix.hpp"
#include "validation/metrics/probe_parts.hpp"
#include "validation/metrics/resample.hpp"

namespace atwood::metrics {
namespace {

constexpr double kParted = 1e-3;  // of the scale; beyond this distance a state error does not depend on the method

// A separation of two states, each kind of vector in units of its size along the motion.
struct Separation {
  const Scene& scene;
  Sizes size;

  double of(const SampleView& a, const SampleView& b) const {
    double sum = 0;
    for (std::size_t i = 0; i < a.bodies.size(); ++i) {
      sum += square(distance(a.bodies[i].p_m, b.bodies[i].p_m), size.position_m);
      if (!scene.problem.empty()) continue;
      sum += square(distance(a.bodies[i].v_m_per_s, b.bodies[i].v_m_per_s), size.velocity_m_per_s);
      sum += square(distance(a.bodies[i].w_rad_per_s, b.bodies[i].w_rad_per_s), size.rate_rad_per_s);
    }
    return std::sqrt(sum);
  }
  static double square(double x, double scale) { return scale > 0 ? x * x / (scale * scale) : 0; }

  // near + factor (far - near)
  Sample between(const SampleView& near, const SampleView& far, double factor) const {
    Sample s = copy_of(near);
    const auto mix = [&](std::array<Wide, 3>& x, const std::array<Wide, 3>& y) {
      for (int i = 0; i < 3; ++i) x[i] += Wide(factor) * (y[i] - x[i]);
    };
    for (std::size_t b = 0; b < s.bodies.size(); ++b) {
      mix(s.bodies[b].p_m, far.bodies[b].p_m);
      mix(s.bodies[b].v_m_per_s, far.bodies[b].v_m_per_s);
      mix(s.bodies[b].w_rad_per_s, far.bodies[b].w_rad_per_s);
    }
    return s;
  }
};

// A twin of `sample` at distance `apart` in a random direction; attitudes and body rates only of bodies that rotate.
Sample twin(const Separation& separation, const SampleView& sample, double apart) {
  SplitMix64 random{0x7477696e};
  Sample far = copy_of(sample);
  for (std::size_t b = 0; b < far.bodies.size(); ++b) {
    if (b < separation.scene.bodies.size() && separation.scene.bodies[b].fixed) continue;
    for (int i = 0; i < 3; ++i) {
      far.bodies[b].p_m[i] += separation.size.position_m * draw_normal(random);
      far.bodies[b].v_m_per_s[i] += separation.size.velocity_m_per_s * draw_normal(random);
      if (b < separation.scene.bodies.size() && rotates(separation.scene.bodies[b]))
        far.bodies[b].w_rad_per_s[i] += separation.size.rate_rad_per_s * draw_normal(random);
    }
  }
  return separation.between(sample, far, apart / separation.of(sample, far));
}

}  // namespace

std::vector<Row> probe_lyapunov(const ProbeRequest& request) {
  require_no_contacts(request);
  require_no_clock(request);
  const Scene& scene = request.scenario.scene;
  const Plan& plan = request.plan;
  const double rtol = parse_method_id(request.method).rtol.value_or(1e-7);
  const double apart = std::max(std::min(1e-10, rtol / 1000), 1e4 * std::max(unit_round_off(request.method), 0x1p-53));
  const Recording run = good_run(request, scene, plan);
  const Separation separation{scene, sizes_of(scene, run.values)};
  const Recording other = good_run(request, started_from(scene, twin(separation, run.values.front(), apart)), plan);

  double horizon = plan.t_end_s, before = std::log(apart);
  std::string reached = "the twins stay nearer than 1e-3 to the end of the run";
  for (std::size_t k = 1; k < run.values.size(); ++k) {
    const double now = std::log(separation.of(run.values[k], other.values[k]));
    if (now >= std::log(kParted)) {
      const double t0 = static_cast<double>(run.values[k - 1].t_s), t1 = static_cast<double>(run.values[k].t_s);
      horizon = t0 + (t1 - t0) * (std::log(kParted) - before) / (now - before);
      reached = "twins " + format_measure(apart, 0, 2) + " of the scale apart are 1e-3 apart";
      break;
    }
    before = now;
  }
  std::vector<Row> rows = {
      row("horizon", horizon, horizon < plan.t_end_s ? plan.t_end_s / static_cast<double>(plan.samples) : 0, reached)};

  // One stretch per sample: both twins start at the end of the last stretch, with the separation rescaled to `apart`.
  const Plan stretch{plan.t_end_s / static_cast<double>(plan.samples), plan.steps / plan.samples, 1, {}};
  Sample near = copy_of(run.values.front()), far = twin(separation, near, apart);
  std::vector<double> local;
  for (std::int64_t k = 0; k < plan.samples; ++k) {
    const double start = separation.of(near, far);
    const Recording a = good_run(request, started_from(scene, near), stretch),
                    b = good_run(request, started_from(scene, far), stretch);
    const double end = separation.of(a.values.back(), b.values.back());
    local.push_back(std::log(end / start) / stretch.t_end_s);
    near = copy_of(a.values.back());
    far = separation.between(near, b.values.back(), apart / end);
  }
  const LyapunovFit fit = fit_lyapunov(local, stretch.t_end_s);
  const std::string stretches =
      std::to_string(fit.stretches) + " stretches of " + format_measure(stretch.t_end_s, 0) + " s";
  if (fit.stretches == 0)
    rows.push_back(row("lyapunov-exponent", std::nan(""), 0, "inconclusive: fewer than 9 stretches"));
  else if (!fit.resolved)
    rows.push_back(row("lyapunov-exponent", std::nan(""), 0,
                       "inconclusive: no exponent is resolved: the separation grows by e^" +
                           format_measure(fit.e_foldings, 0, 2) + ", like t^2 it would by e^" +
                           format_measure(fit.e_foldings_of_power, 0, 2) + "; mean rate " +
                           format_measure(fit.exponent_per_s, 0, 3) + " +/- " +
                           format_measure(fit.half_width_95, 0, 2) + " 1/s over " + stretches));
  else rows.push_back(row("lyapunov-exponent", fit.exponent_per_s, fit.half_width_95, stretches));
  return rows;
}

}  // namespace atwood::metrics
