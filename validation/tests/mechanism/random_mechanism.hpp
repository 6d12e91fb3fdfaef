// Random trees of all kinds of joints, for tests that compare formulations.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "scene/scene.hpp"

namespace atwood {

class Draw {  // SplitMix64 (Steele, Lea and Flood 2014)
 public:
  explicit Draw(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  double uniform(double from, double to) { return from + (to - from) * static_cast<double>(bits() >> 11) * 0x1p-53; }
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint64_t>(n)); }
  Real3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Real3 direction() {
    const Real3 v = vector(1);
    const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return {v[0] / length, v[1] / length, v[2] / length};
  }
  Real4 attitude() {
    Real4 q{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& part : q) part /= length;
    return q;
  }

 private:
  std::uint64_t state_;
};

inline Body random_body(Draw& draw, const std::string& name) {
  Body body;
  body.name = name;
  body.mass_kg = draw.uniform(0.5, 3);
  // Positive definite, with the triangle inequality: I = tr(C) 1 - C for a covariance C = A A^T.
  double A[9], C[9]{};
  for (double& a : A) a = draw.uniform(-0.5, 0.5);
  double trace = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) C[3 * i + j] += A[3 * i + k] * A[3 * j + k];
      if (i == j) C[3 * i + j] += 0.05;
    }
  for (int i = 0; i < 3; ++i) trace += C[4 * i];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) body.inertia_kg_m2[3 * i + j] = (i == j ? trace : 0) - C[3 * i + j];
  body.position_m = draw.vector(2);
  body.orientation_wxyz = draw.attitude();
  body.velocity_m_per_s = draw.vector(1);
  body.angular_velocity_body_rad_per_s = draw.vector(2);
  return body;
}

// `kind`: of this joint. The universal joint's axes are orthogonal to round-off at angle 0.
inline Joint random_joint(Draw& draw, JointKind kind, int parent, int child) {
  Joint joint;
  joint.name = "joint-" + std::to_string(child);
  joint.kind = kind;
  joint.parent = parent;
  joint.child = child;
  joint.anchors_body_m = {draw.vector(0.7), draw.vector(0.7)};
  joint.frame_wxyz = draw.attitude();
  joint.axis_body = draw.direction();
  if (kind == JointKind::universal) {
    const Real3 a = draw.direction(), b = draw.direction();
    Real3 c{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const double length = std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    for (double& part : c) part /= length;
    joint.frame_wxyz = {1, 0, 0, 0};
    joint.axes_body = {a, c};
  }
  if (kind == JointKind::ball) joint.coordinates = draw.attitude();
  else
    for (int k = 0; k < coordinate_count(kind); ++k) joint.coordinates[k] = draw.uniform(-1.2, 1.2);
  for (int k = 0; k < rate_count(kind); ++k) joint.rates[k] = draw.uniform(-2, 2);
  return joint;
}

inline constexpr JointKind kAllKinds[] = {JointKind::fixed,       JointKind::hinge,     JointKind::slider,
                                          JointKind::cylindrical, JointKind::universal, JointKind::ball};

// A floating base or the world, and `count` bodies on it in a random tree, with springs, dampers and torques of joints,
// springs between bodies, drag and gravity, and a free body that a spring ties to the tree.
inline Scene random_tree(std::uint64_t seed, int count) {
  Draw draw(seed);
  Scene scene;
  scene.gravity_m_per_s2 = {0.3, -1, -9.81};
  scene.materials.emplace_back();
  scene.pairs.emplace_back();
  const bool floating = draw.below(2) == 0;
  if (floating) scene.bodies.push_back(random_body(draw, "base"));
  const int first = static_cast<int>(scene.bodies.size());
  for (int i = first; i < first + count; ++i) {
    scene.bodies.push_back(random_body(draw, "body-" + std::to_string(i)));
    const int parent = i == 0 ? -1 : draw.below(i + (floating ? 0 : 1)) - (floating ? 0 : 1);
    scene.joints.push_back(random_joint(draw, kAllKinds[draw.below(6)], parent, i));
    const int j = static_cast<int>(scene.joints.size()) - 1;
    const JointKind kind = scene.joints.back().kind;
    if (rate_count(kind) == 0) continue;
    JointSpring spring;
    spring.joint = j;
    spring.coordinate = kind == JointKind::ball ? 0 : draw.below(rate_count(kind));
    spring.stiffness = kind == JointKind::ball ? 0 : draw.uniform(0, 20);
    spring.rest = draw.uniform(-1, 1);
    spring.damping = draw.uniform(0, 2);
    scene.joint_forces.emplace_back(spring);
    if (kind != JointKind::ball) scene.joint_forces.emplace_back(JointTorque{j, 0, draw.uniform(-3, 3), 2, 0.3, {}});
  }
  scene.bodies.push_back(random_body(draw, "free"));
  const int free = static_cast<int>(scene.bodies.size()) - 1;
  scene.forces.emplace_back(Spring{{free, free - 1}, {}, 30, 0.5, 0.7, {draw.vector(0.3), draw.vector(0.3)}});
  scene.forces.emplace_back(LinearDrag{{0, free - 1}, 0.4, {0.2, 0, 0.1}, 0.05});
  return scene;
}

}  // namespace atwood
