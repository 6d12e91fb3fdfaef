// Scenes, runs and sums that the tests of "+impulse" share.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "contact/stepping/run.hpp"
#include "validation/tests/catalogued.hpp"
#include "validation/tests/recorded.hpp"

namespace atwood::stepping_scenes {

using testing::Recorded;

// Runs `scene` and returns what was observed, whatever the outcome's status: for tests of a refusal.
inline Recorded try_run(const std::string& method, const Scene& scene, const Plan& plan) {
  return testing::record(run_impulse, parse_method_id(method), scene, plan);
}

// Runs `scene`; the test fails here unless the run ended ok with all its samples.
inline Recorded run(const std::string& method, const Scene& scene, const Plan& plan) {
  Recorded recorded = try_run(method, scene, plan);
  testing::require_whole(recorded, method, plan);
  return recorded;
}

inline Scene catalogue(const std::string& id) { return testing::catalogued(id).scene; }

inline Body ball(const std::string& name, double mass_kg, double radius_m, const Real3& p, const Real3& v,
                 const Real3& w = {}) {
  Body body;
  body.name = name;
  body.mass_kg = mass_kg;
  const double I = 0.4 * mass_kg * radius_m * radius_m;
  body.inertia_kg_m2 = {I, 0, 0, 0, I, 0, 0, 0, I};
  body.shape = Sphere{radius_m};
  body.position_m = p;
  body.velocity_m_per_s = v;
  body.angular_velocity_body_rad_per_s = w;
  return body;
}

inline Body box(const std::string& name, double mass_kg, const Real3& half, const Real3& p) {
  Body body;
  body.name = name;
  body.mass_kg = mass_kg;
  const double x = half[0] * half[0], y = half[1] * half[1], z = half[2] * half[2];
  body.inertia_kg_m2 = {mass_kg * (y + z) / 3, 0, 0, 0, mass_kg * (x + z) / 3, 0, 0, 0, mass_kg * (x + y) / 3};
  body.shape = Box{half};
  body.position_m = p;
  return body;
}

inline Body floor_plane() {
  Body plane;
  plane.name = "floor";
  plane.shape = Plane{{0, 0, 1}, 0};
  plane.fixed = true;
  return plane;
}

inline Scene scene_of(std::vector<Body> bodies, double restitution, double friction, double g = 0) {
  Scene scene;
  scene.gravity_m_per_s2 = {0, 0, -g};
  scene.materials = {{"stuff", restitution, friction, 0}};
  scene.pairs = {PairLaw{}};
  scene.pairs[0].restitution = restitution;
  scene.pairs[0].friction = friction;
  scene.bodies = std::move(bodies);
  return scene;
}

struct Total {
  Real3 P{}, L{};
  double energy = 0;
};
inline Total total(const Scene& scene, const Sample& sample) {
  Total out;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.fixed) continue;
    double p[3], v[3], w[3];
    for (int c = 0; c < 3; ++c) {
      p[c] = static_cast<double>(sample.bodies[i].p_m[c]);
      v[c] = static_cast<double>(sample.bodies[i].v_m_per_s[c]);
      w[c] = static_cast<double>(sample.bodies[i].w_rad_per_s[c]);
    }
    const double qw = static_cast<double>(sample.bodies[i].q_wxyz[0]);
    const double q[3] = {static_cast<double>(sample.bodies[i].q_wxyz[1]),
                         static_cast<double>(sample.bodies[i].q_wxyz[2]),
                         static_cast<double>(sample.bodies[i].q_wxyz[3])};
    double spin[3];
    for (int c = 0; c < 3; ++c) spin[c] = body.inertia_kg_m2[4 * c] * w[c];
    const auto cross = [](const double* a, const double* b, int c) {
      return a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
    };
    double t[3], turned[3];
    for (int c = 0; c < 3; ++c) t[c] = 2 * cross(q, spin, c);
    for (int c = 0; c < 3; ++c) turned[c] = spin[c] + qw * t[c] + cross(q, t, c);
    for (int c = 0; c < 3; ++c) {
      out.P[c] += body.mass_kg * v[c];
      out.L[c] += body.mass_kg * cross(p, v, c) + turned[c];
      out.energy += body.mass_kg * (v[c] * v[c] / 2 - scene.gravity_m_per_s2[c] * p[c]) +
                    body.inertia_kg_m2[4 * c] * w[c] * w[c] / 2;
    }
  }
  return out;
}

inline double farthest_moved(const Recorded& r, const Scene& scene) {
  double most = 0;
  for (const Sample& s : r.samples)
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      double square = 0;
      for (int c = 0; c < 3; ++c) {
        const auto d = static_cast<double>(s.bodies[i].p_m[c] - r.samples[0].bodies[i].p_m[c]);
        square += d * d;
      }
      most = std::max(most, std::sqrt(square));
    }
  return most;
}

inline bool same_bits(const Sample& a, const Sample& b) {
  for (std::size_t i = 0; i < a.bodies.size(); ++i)
    if (a.bodies[i].p_m != b.bodies[i].p_m || a.bodies[i].q_wxyz != b.bodies[i].q_wxyz ||
        a.bodies[i].v_m_per_s != b.bodies[i].v_m_per_s || a.bodies[i].w_rad_per_s != b.bodies[i].w_rad_per_s)
      return false;
  return true;
}

inline const std::string euler = "atwood/symplectic-euler+impulse";

}  // namespace atwood::stepping_scenes
