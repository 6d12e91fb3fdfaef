// Reversal: n steps, velocities reversed, n steps, velocities reversed. A reversible method returns to the start up to
// round-off (Hairer, Lubich and Wanner 2006, ch. V).
//
// The motion itself must be reversible: magnetic fields and rotations of frames are reversed with the velocities.
#include <algorithm>
#include <cmath>

#include "validation/metrics/probe_parts.hpp"

namespace atwood::metrics {
namespace {

void turn_round(Scene& scene) {
  for (Body& body : scene.bodies)
    for (int i = 0; i < 3; ++i) {
      body.velocity_m_per_s[i] = -body.velocity_m_per_s[i];
      body.angular_velocity_body_rad_per_s[i] = -body.angular_velocity_body_rad_per_s[i];
    }
  for (Force& force : scene.forces) {
    if (auto* magnetic = std::get_if<Lorentz>(&force))
      for (double& b : magnetic->magnetic_T) b = -b;
    if (auto* frame = std::get_if<RotatingFrame>(&force))
      for (double& w : frame->angular_velocity_rad_per_s) w = -w;
  }
}

std::array<Wide, 3> reversed(const std::array<Wide, 3>& v) { return {-v[0], -v[1], -v[2]}; }

}  // namespace

std::vector<Row> probe_reversal(const ProbeRequest& request) {
  require_bodies(request);
  require_no_contacts(request);
  require_no_clock(request);
  require_no_dissipation(request);
  const Scene& scene = request.scenario.scene;
  const Recording there = good_run(request, scene, request.plan);
  Scene back_scene = started_from(scene, there.values.back());
  turn_round(back_scene);
  const Recording back = good_run(request, back_scene, request.plan);

  double position = 0, velocity = 0, attitude = 0, rate = 0;
  bool turns = false;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].fixed) continue;
    const BodySample& start = there.values.front().bodies[b];
    const BodySample& end = back.values.back().bodies[b];
    position = std::max(position, position_error_m(end, start));
    velocity = std::max(velocity, distance(reversed(end.v_m_per_s), start.v_m_per_s));
    if (!rotates(scene.bodies[b])) continue;
    turns = true;
    attitude = std::max(attitude, attitude_error_rad(end, start));
    rate = std::max(rate, distance(reversed(end.w_rad_per_s), start.w_rad_per_s));
  }
  const Sizes size = sizes_of(scene, there.values);
  const double growth = std::max(1.0, perturbation_growth(request.scenario, request.truth));
  // The state between the two passes is rounded to the scene's doubles, also for wider arithmetic.
  const double unit = std::max(unit_round_off(request.method), 0x1p-53);
  const auto floors = [&](double scale) {
    return round_off_floor(unit, 2 * static_cast<double>(request.plan.steps), scale, growth);
  };
  std::vector<Row> rows = {row("reversal-error-position", position), row("reversal-error-velocity", velocity)};
  double worst = 0;
  const auto compare = [&](double error, double scale) {
    if (scale > 0) worst = std::max(worst, error / floors(scale));
  };
  compare(position, size.position_m);
  compare(velocity, size.velocity_m_per_s);
  if (turns) {
    rows.push_back(row("reversal-error-attitude", attitude));
    rows.push_back(row("reversal-error-body-rate", rate));
    compare(attitude, 1);
    compare(rate, size.rate_rad_per_s);
  }
  rows.push_back(row("reversal-over-round-off", worst, 0,
                     "round-off there and back: " + format_measure(floors(size.position_m), 0, 2) + " m, condition " +
                         format_measure(growth, 0, 2)));
  return rows;
}

}  // namespace atwood::metrics
