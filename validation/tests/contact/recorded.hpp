// Scenes of the contact tests, and runs of them with their samples and events.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "simulation.hpp"
#include "validation/tests/recorded.hpp"

namespace atwood::recorded {

using testing::Recorded;

// Runs `scene` and returns what was observed, whatever the outcome's status: for tests of a refusal.
inline Recorded try_run(const std::string& method, const Scene& scene, const Plan& plan) {
  return testing::record(run_with_contacts, parse_method_id(method), scene, plan);
}

// Runs `scene`; the test fails here unless the run ended ok with all its samples.
inline Recorded run(const std::string& method, const Scene& scene, const Plan& plan) {
  Recorded recorded = try_run(method, scene, plan);
  testing::require_whole(recorded, method, plan);
  return recorded;
}

inline double time_of(const Event& event) { return static_cast<double>(event.t_s); }

inline Scene world(const Real3& gravity, double restitution, double friction) {
  Scene scene;
  scene.gravity_m_per_s2 = gravity;
  scene.materials = {{"stuff", restitution, friction, 0}};
  scene.pairs = {{0, 0, restitution, friction, 0}};
  return scene;
}

inline Body fixed(const std::string& name, Shape shape, const Real3& at = {}) {
  Body body;
  body.name = name;
  body.shape = std::move(shape);
  body.fixed = true;
  body.position_m = at;
  return body;
}

// I: principal moments for 1 kg.
inline Body moving(const std::string& name, Shape shape, double mass_kg, const Real3& I, const Real3& at,
                   const Real3& velocity = {}, const Real3& spin = {}) {
  Body body;
  body.name = name;
  body.shape = std::move(shape);
  body.mass_kg = mass_kg;
  body.inertia_kg_m2 = {mass_kg * I[0], 0, 0, 0, mass_kg * I[1], 0, 0, 0, mass_kg * I[2]};
  body.position_m = at;
  body.velocity_m_per_s = velocity;
  body.angular_velocity_body_rad_per_s = spin;
  return body;
}

inline Body ball(const std::string& name, double mass_kg, double r, const Real3& at, const Real3& velocity = {},
                 const Real3& spin = {}) {
  return moving(name, Sphere{r}, mass_kg, {0.4 * r * r, 0.4 * r * r, 0.4 * r * r}, at, velocity, spin);
}

inline Body box(const std::string& name, double mass_kg, const Real3& half, const Real3& at,
                const Real3& velocity = {}) {
  const double a = half[0] * half[0], b = half[1] * half[1], c = half[2] * half[2];
  return moving(name, Box{half}, mass_kg, {(b + c) / 3, (a + c) / 3, (a + b) / 3}, at, velocity);
}

inline Mesh flat_mesh(double a, double b) {  // two triangles that share a diagonal through the origin
  Mesh mesh;
  mesh.points_m = {{-a, -b, 0}, {a, -b, 0}, {a, b, 0}, {-a, b, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

}  // namespace atwood::recorded
