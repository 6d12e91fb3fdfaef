// Scenes of the catalogue that rivals are tested on, built in place, and runs of them.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "validation/tests/recorded.hpp"

namespace atwood::test {

inline Scene empty_scene() {
  Scene scene;
  scene.materials = {Material{"default", 0, 0, 0}};
  scene.pairs = {PairLaw{0, 0, 0, 0, 0}};
  return scene;
}

inline Body box_body(const std::string& name, double mass_kg, const Real3& inertia) {
  Body body;
  body.name = name;
  body.mass_kg = mass_kg;
  body.inertia_kg_m2 = {inertia[0], 0, 0, 0, inertia[1], 0, 0, 0, inertia[2]};
  return body;
}

inline Body sphere_body(const std::string& name, double mass_kg, double radius_m, const Real3& position_m) {
  const double i = 0.4 * mass_kg * radius_m * radius_m;
  Body body = box_body(name, mass_kg, {i, i, i});
  body.shape = Sphere{radius_m};
  body.position_m = position_m;
  return body;
}

// The tumbling box of the free-box scenarios: 10 kg, 0.1 x 0.4 x 0.9 m, under gravity, spun near its middle axis.
inline Scene free_box_complex() {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.8};
  Body box = box_body("box", 10, {10.0 / 12 * (0.16 + 0.81), 10.0 / 12 * (0.01 + 0.81), 10.0 / 12 * (0.01 + 0.16)});
  box.shape = Box{{0.05, 0.2, 0.45}};
  box.velocity_m_per_s = {-2, 2, 8};
  box.angular_velocity_body_rad_per_s = {0.1, 5, 0.1};
  scene.bodies = {box};
  return scene;
}

// A ball dropped from clearance h0 onto the plane z = 0.
inline Scene bounce(double restitution, double h0_m, double friction = 0) {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  scene.pairs[0].restitution = restitution;
  scene.pairs[0].friction = friction;
  Body floor;
  floor.name = "floor";
  floor.fixed = true;
  floor.shape = Plane{};
  scene.bodies = {floor, sphere_body("ball", 1, 0.1, {0, 0, 0.1 + h0_m})};
  return scene;
}

inline Scene head_on(double restitution, double m1_kg, double m2_kg) {
  Scene scene = empty_scene();
  scene.pairs[0].restitution = restitution;
  scene.bodies = {sphere_body("left", m1_kg, 0.1, {-0.5, 0, 0}), sphere_body("right", m2_kg, 0.1, {0.5, 0, 0})};
  scene.bodies[0].velocity_m_per_s = {1, 0, 0};
  scene.bodies[1].velocity_m_per_s = {-0.5, 0, 0};
  return scene;
}

inline Body flat_box(const std::string& name, const Real3& position_m) {
  Body box = box_body(name, 1, {0.17 / 12, 0.17 / 12, 0.32 / 12});
  box.shape = Box{{0.2, 0.2, 0.05}};
  box.position_m = position_m;
  return box;
}

// A box that slides over the floor, v0 = 2 m/s: it stops after v0^2 / (2 mu g).
inline Scene sliding_box(double mu, double cos, double sin) {
  Scene scene = bounce(0, 0, mu);
  scene.bodies[1] = flat_box("box", {0, 0, 0.05});
  scene.bodies[1].velocity_m_per_s = {2 * cos, 2 * sin, 0};
  return scene;
}

struct Run : testing::Recorded {
  double p(int body, int axis) const { return static_cast<double>(samples.back().bodies[body].p_m[axis]); }
  double v(int body, int axis) const { return static_cast<double>(samples.back().bodies[body].v_m_per_s[axis]); }
  double w(int body, int axis) const { return static_cast<double>(samples.back().bodies[body].w_rad_per_s[axis]); }
  Real4 q(int body) const {
    Real4 q{};
    for (int k = 0; k < 4; ++k) q[k] = static_cast<double>(samples.back().bodies[body].q_wxyz[k]);
    return q;
  }
};

// Runs `scene` and returns what was observed, whatever the outcome's status: for tests of a refusal.
inline Run try_run(const Engine& engine, const MethodId& id, const Scene& scene, const Plan& plan) {
  return {testing::record(engine.run, id, scene, plan)};
}

// Runs `scene`; the test fails here unless the run ended ok with all its samples.
inline Run run(const Engine& engine, const MethodId& id, const Scene& scene, const Plan& plan) {
  Run result = try_run(engine, id, scene, plan);
  testing::require_whole(result, to_string(id), plan);
  return result;
}

inline MethodId method(const Engine& engine, const std::string& scheme, const Settings& overrides = {}) {
  MethodId id;
  id.engine = engine.name;
  id.scheme = scheme;
  id.overrides = overrides;
  return id;
}

// Worst error of the first five apexes of a ball at restitution e, relative to h0. An apex of the samples is the top of
// the parabola through the three samples about their highest one.
inline double worst_apex_error(const std::vector<Sample>& samples, int ball, double rest_z_m, double e, double h0_m) {
  std::vector<double> apexes;
  const auto z = [&](std::size_t k) { return static_cast<double>(samples[k].bodies[ball].p_m[2]) - rest_z_m; };
  for (std::size_t k = 2; k + 1 < samples.size() && apexes.size() < 5; ++k) {
    if (!(z(k) > z(k - 1) && z(k) >= z(k + 1))) continue;
    const double a = z(k - 1) - 2 * z(k) + z(k + 1), b = 0.5 * (z(k + 1) - z(k - 1));
    apexes.push_back(a < 0 ? z(k) - 0.5 * b * b / a : z(k));
  }
  double worst = 0;
  for (int k = 1; k <= 5; ++k) {
    const double exact = std::pow(e, 2 * k) * h0_m;
    const double found = k <= static_cast<int>(apexes.size()) ? apexes[k - 1] : 0;
    worst = std::max(worst, std::abs(found - exact) / exact);
  }
  return worst;
}

// Geodesic angle between two attitudes.
inline double angle_between(const Real4& a, const Real4& b) {
  const double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  double sine2 = 0;
  for (int k = 0; k < 4; ++k) {
    const double d = a[k] - (dot < 0 ? -b[k] : b[k]);
    sine2 += d * d;
  }
  return 4 * std::asin(std::min(1.0, 0.5 * std::sqrt(sine2)));
}

}  // namespace atwood::test
