// Parts of random scenes.
#pragma once

#include <cmath>

#include "kinds.hpp"
#include "validation/tests/closed_form/scenes.hpp"

namespace atwood::fuzz {

constexpr double kPi = 3.141592653589793;

using testing::ball, testing::joint, testing::point, testing::solid;

inline Scenario empty(TruthKind truth, const std::string& solution, double t_end_s) {
  Scenario made = testing::scenario(solution, t_end_s);
  made.samples = 4;
  made.truth.kind = truth;
  return made;
}

inline Body turning(Body body, Real3 moments, Real3 w) {
  body.inertia_kg_m2 = {moments[0], 0, 0, 0, moments[1], 0, 0, 0, moments[2]};
  body.angular_velocity_body_rad_per_s = w;
  return body;
}

inline Body peg(const std::string& name, double radius_m, Real3 p) {
  Body body = ball(name, 0, radius_m, p, {});
  body.inertia_kg_m2 = {};
  body.fixed = true;
  return body;
}

inline Body plane(Real3 normal, double offset_m) {
  Body body = point("plane", 0, {}, {});
  body.fixed = true;
  body.shape = Plane{normal, offset_m};
  return body;
}

inline double few_bits(double x) { return static_cast<double>(static_cast<float>(x)); }
inline Real3 scaled(double s, const Real3& v) { return {s * v[0], s * v[1], s * v[2]}; }
inline Real3 sum(const Real3& a, const Real3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Real3 across(const Real3& n, Random& random) {  // a unit vector orthogonal to n, to round-off
  const Real3 v = random.direction();
  const double along = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
  const Real3 flat = sum(v, scaled(-along, n));
  return scaled(1 / std::sqrt(flat[0] * flat[0] + flat[1] * flat[1] + flat[2] * flat[2]), flat);
}
inline double inner(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline Real4 any_orientation(Random& random) {
  const Real3 n = random.direction();
  const double half = random.uniform(-1.5, 1.5), s = std::sin(half);
  return {std::cos(half), s * n[0], s * n[1], s * n[2]};
}

// Three pairs of points on orthogonal lines, skewed by a small product of inertia.
inline Body any_body(const std::string& name, Random& random) {
  const double a = random.uniform(0.1, 1), b = random.uniform(0.1, 1), c = random.uniform(0.1, 1);
  Body made = solid(name, random.uniform(0.5, 3), {b + c, c + a, a + b}, {0, 0, 0});
  if (random.whole(0, 1)) made.inertia_kg_m2[1] = made.inertia_kg_m2[3] = random.uniform(-0.05, 0.05);
  return made;
}

// The world's joints of half of the scenes are on a fixed body instead.
inline void stand_on_body(Scenario& given, Random& random) {
  if (random.whole(0, 1)) return;
  Body wall = point("wall", 0, random.vector(1), {0, 0, 0});
  wall.fixed = true;
  wall.orientation_wxyz = any_orientation(random);
  given.scene.bodies.push_back(wall);
  for (Joint& each : given.scene.joints)
    if (each.parent < 0) each.parent = static_cast<int>(given.scene.bodies.size()) - 1;
}

}  // namespace atwood::fuzz
