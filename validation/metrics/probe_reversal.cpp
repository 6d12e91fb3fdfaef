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

// The fluids' particles at the end of the run, with their velocities reversed.
Scene fluids_turned_round(Scene scene, const SampleView& end) {
  std::size_t at = 0;
  for (Fluid& fluid : scene.fluids)
    for (std::size_t i = 0; i < fluid.particles.mass_kg.size(); ++i, ++at) {
      const ParticleSample& particle = checked(end.particles, at);
      for (int c = 0; c < 3; ++c) {
        fluid.particles.position_m[i][c] = static_cast<double>(particle.p_m[c]);
        fluid.particles.velocity_m_per_s[i][c] = -static_cast<double>(particle.v_m_per_s[c]);
      }
      fluid.particles.density_kg_per_m3[i] = static_cast<double>(particle.density_kg_per_m3);
    }
  return scene;
}

// Of a fluid without friction, by the worst particle. It is compared with the run's first sample, not with the scene: a
// method on a lattice begins at the lattice's nearest point.
std::vector<Row> reversal_of_fluids(const ProbeRequest& request) {
  const Scene& scene = request.scenario.scene;
  for (const Fluid& fluid : scene.fluids)
    if (fluid.viscosity_m2_per_s > 0)
      throw ProbeEnds(Status::unsupported,
                      "the fluid `" + fluid.name + "` has viscosity: its motion does not run back");
  if (!scene.bodies.empty()) throw ProbeEnds(Status::unsupported, "fluids can be reversed only without bodies");
  const Recording there = good_run(request, scene, request.plan);
  const Recording back = good_run(request, fluids_turned_round(scene, there.values.back()), request.plan);
  double position = 0, velocity = 0;
  const std::span<const ParticleSample> start = there.values.front().particles, end = back.values.back().particles;
  if (start.size() != end.size())
    throw ProbeEnds(Status::crashed,
                    std::to_string(end.size()) + " particles came back of " + std::to_string(start.size()));
  for (std::size_t i = 0; i < start.size(); ++i) {
    position = std::max(position, distance(end[i].p_m, start[i].p_m));
    velocity = std::max(velocity, distance(reversed(end[i].v_m_per_s), start[i].v_m_per_s));
  }
  return {row("reversal-error-position", position), row("reversal-error-velocity", velocity)};
}

}  // namespace

std::vector<Row> probe_reversal(const ProbeRequest& request) {
  if (!request.scenario.scene.fluids.empty()) return reversal_of_fluids(request);
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
  const double growth = std::max(1.0, perturbation_growth(request.scenario, request.truth).value);
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
