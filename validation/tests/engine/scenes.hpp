// Scenes of the engine's tests, and runs of them.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "integrators/catalogue.hpp"
#include "rigid/model.hpp"
#include "simulation.hpp"
#include "smooth/run.hpp"
#include "validation/tests/recorded.hpp"

namespace atwood::testing {

// The stepper of a scheme that takes the model.
template <class S>
std::unique_ptr<Stepper<S>> stepper_of(const std::string& scheme, RigidModel<S>& model, const Settings& settings = {}) {
  Result<std::unique_ptr<Stepper<S>>> stepper = make_stepper(scheme, model, settings);
  INFO(scheme << ": " << (stepper ? "" : stepper.fault().reason));
  REQUIRE(stepper);
  return std::move(*stepper);
}

inline Scene empty_scene() {
  Scene scene;
  scene.materials.push_back({"default", 0, 0, 0});
  return scene;
}

inline Body point(const std::string& name, double mass_kg, Real3 p, Real3 v) {
  Body body;
  body.name = name;
  body.mass_kg = mass_kg;
  body.position_m = p;
  body.velocity_m_per_s = v;
  return body;
}

inline Body box(Real3 moments, Real3 w) {
  Body body = point("box", 10, {0, 0, 0}, {-2, 2, 8});
  body.inertia_kg_m2 = {moments[0], 0, 0, 0, moments[1], 0, 0, 0, moments[2]};
  body.angular_velocity_body_rad_per_s = w;
  return body;
}

inline Scene ballistic() {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.8};
  scene.bodies.push_back(point("ball", 1, {0, 0, 0}, {7.5, 0, 7.5}));
  return scene;
}

inline Scene oscillator(double damping = 0) {
  Scene scene = empty_scene();
  scene.bodies.push_back(point("bob", 2, {1, 0, 0}, {0, 0, 0}));
  Spring spring;
  spring.bodies = {0};
  spring.stiffness_N_per_m = 8;
  spring.damping_N_s_per_m = damping;
  scene.forces.push_back(spring);
  return scene;
}

// Not autonomous: a method that evaluates a stage at the wrong instant loses its order here.
inline Scene driven_oscillator() {
  Scene scene = oscillator();
  scene.forces.push_back(Drive{{0}, {3, 0, 0}, 2.7, 0.4});
  return scene;
}

inline Scene kepler(double e) {
  Scene scene = empty_scene();
  scene.bodies.push_back(point("planet", 1, {1 - e, 0, 0}, {0, std::sqrt((1 + e) / (1 - e)), 0}));
  scene.forces.push_back(Attractor{{0}, {0, 0, 0}, 1});
  return scene;
}

inline Scene free_box(bool gravity = true) {
  Scene scene = empty_scene();
  if (gravity) scene.gravity_m_per_s2 = {0, 0, -9.8};
  scene.bodies.push_back(
      box({10.0 / 12 * (0.16 + 0.81), 10.0 / 12 * (0.01 + 0.81), 10.0 / 12 * (0.01 + 0.16)}, {0.1, 5, 0.1}));
  return scene;
}

inline Scene quadratic_drag() {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.8};
  scene.bodies.push_back(point("ball", 0.5, {0, 0, 0}, {20, 3, 15}));
  QuadraticDrag drag;
  drag.bodies = {0};
  drag.density_kg_per_m3 = 1.2;
  drag.drag_coefficient = 0.47;
  drag.area_m2 = 0.05;
  drag.wind_m_per_s = {-3, 1, 0};
  scene.forces.push_back(drag);
  return scene;
}

inline Scene e_cross_b() {
  Scene scene = empty_scene();
  scene.bodies.push_back(point("ion", 1.5, {0, 0, 0}, {1, 0.2, 0.3}));
  scene.bodies[0].charge_C = 2;
  scene.forces.push_back(Lorentz{{0}, {0.1, 0.3, 0}, {0, 0, 1.5}});
  return scene;
}

// A body that tumbles under a thruster and angular drag: torque, attitude and velocity all act on each other.
inline Scene thrust_and_drag() {
  Scene scene = empty_scene();
  scene.bodies.push_back(box({0.6, 0.8, 1.0}, {0.3, 1, 0.2}));
  scene.bodies[0].mass_kg = 2;
  scene.bodies[0].inertia_kg_m2 = {0.6, 0.02, 0.01, 0.02, 0.8, -0.03, 0.01, -0.03, 1.0};
  scene.forces.push_back(Thruster{0, {0.1, 0.2, 0}, {0, 0, 1}, 1.5, {}});
  LinearDrag drag;
  drag.bodies = {0};
  drag.coefficient_kg_per_s = 0.3;
  drag.angular_coefficient_N_m_s = 0.1;
  scene.forces.push_back(drag);
  return scene;
}

// Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.10.
inline Scene pleiades() {
  Scene scene = empty_scene();
  const double x[] = {3, 3, -1, -3, 2, -2, 2}, y[] = {3, -3, 2, 0, 0, -4, 4}, vx[] = {0, 0, 0, 0, 0, 1.75, -1.5},
               vy[] = {0, 0, 0, -1.25, 1, 0, 0};
  MutualGravity gravity;
  gravity.constant_m3_per_kg_s2 = 1;
  for (int i = 0; i < 7; ++i) {
    scene.bodies.push_back(point("star-" + std::to_string(i + 1), i + 1, {x[i], y[i], 0}, {vx[i], vy[i], 0}));
    gravity.bodies.push_back(i);
  }
  scene.forces.push_back(gravity);
  return scene;
}

// Runs `scene` and returns what was observed, whatever the outcome's status: for tests of a refusal or a divergence.
inline Recorded try_run(const MethodId& id, const Scene& scene, const Plan& plan) {
  return record(atwood_engine().run, id, scene, plan);
}

// Runs `scene`; the test fails here unless the run ended ok with all its samples.
inline Recorded run(const MethodId& id, const Scene& scene, const Plan& plan) {
  Recorded recorded = try_run(id, scene, plan);
  require_whole(recorded, to_string(id), plan);
  return recorded;
}

// rtol 0: fixed steps.
inline MethodId method_id(const std::string& scheme, const std::string& scalar = "", double rtol = 0) {
  MethodId id;
  id.engine = "atwood";
  id.scheme = scheme;
  id.scalar = scalar;
  if (rtol > 0) id.rtol = rtol;
  return id;
}
inline Recorded try_run(const std::string& scheme, const Scene& scene, const Plan& plan, const std::string& scalar = "",
                        double rtol = 0) {
  return try_run(method_id(scheme, scalar, rtol), scene, plan);
}
inline Recorded run(const std::string& scheme, const Scene& scene, const Plan& plan, const std::string& scalar = "",
                    double rtol = 0) {
  return run(method_id(scheme, scalar, rtol), scene, plan);
}

inline double distance(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) sum += static_cast<double>((a[i] - b[i]) * (a[i] - b[i]));
  return std::sqrt(sum);
}
inline double attitude_distance(const std::array<Wide, 4>& a, const std::array<Wide, 4>& b) {
  double plus = 0, minus = 0;
  for (int i = 0; i < 4; ++i) {
    plus += static_cast<double>((a[i] + b[i]) * (a[i] + b[i]));
    minus += static_cast<double>((a[i] - b[i]) * (a[i] - b[i]));
  }
  return 2 * std::sqrt(std::min(plus, minus));
}

}  // namespace atwood::testing
