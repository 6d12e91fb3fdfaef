// Mechanisms that rivals are tested on. place() computes the poses of placed bodies from the coordinates by the
// definition of each kind (scene/joint.hpp), on its own.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace atwood::test {

using V3 = Eigen::Vector3d;
using M3 = Eigen::Matrix3d;

inline V3 v3(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }
inline V3 v3(const std::array<Wide, 3>& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}
inline Eigen::Quaterniond quaternion(const std::array<double, 4>& q) { return {q[0], q[1], q[2], q[3]}; }
inline Eigen::Quaterniond quaternion(const std::array<Wide, 4>& q) {
  return {static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2]), static_cast<double>(q[3])};
}
inline M3 turn(const V3& axis, double angle) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); }
inline std::array<double, 3> unit(double x, double y, double z) {
  const V3 v = V3(x, y, z).normalized();
  return {v[0], v[1], v[2]};
}
inline std::array<double, 4> unit(double w, double x, double y, double z) {
  const Eigen::Vector4d q = Eigen::Vector4d(w, x, y, z).normalized();
  return {q[0], q[1], q[2], q[3]};
}

struct Pose {
  V3 p = V3::Zero();
  M3 r = M3::Identity();
  V3 v = V3::Zero(), w = V3::Zero();  // world axes
};
inline Pose pose_of(const Scene& scene, int body) {
  if (body < 0) return {};
  const Body& b = scene.bodies[static_cast<std::size_t>(body)];
  const M3 r = quaternion(b.orientation_wxyz).toRotationMatrix();
  return {v3(b.position_m), r, v3(b.velocity_m_per_s), r * v3(b.angular_velocity_body_rad_per_s)};
}
inline Pose pose_of(const Sample& sample, int body) {
  if (body < 0) return {};
  const BodySample& b = sample.bodies[static_cast<std::size_t>(body)];
  const M3 r = quaternion(b.q_wxyz).toRotationMatrix();
  return {v3(b.p_m), r, v3(b.v_m_per_s), r * v3(b.w_rad_per_s)};
}

// The child's pose and velocity from its parent's and the joint's coordinates and rates.
template <class Four, class Three>
Pose child_pose(const Joint& joint, const Pose& parent, const Four& q_, const Three& u_) {
  std::array<double, 4> q{};
  std::array<double, 3> u{};
  for (int k = 0; k < 4; ++k) q[k] = static_cast<double>(q_[k]);
  for (int k = 0; k < 3; ++k) u[k] = static_cast<double>(u_[k]);
  const M3 frame = quaternion(joint.frame_wxyz).toRotationMatrix();
  const V3 axis = v3(joint.axis_body), first = v3(joint.axes_body[0]), second = v3(joint.axes_body[1]);
  Pose child = parent;
  V3 w_rel = V3::Zero(), slide = V3::Zero(), slide_rate = V3::Zero();
  M3 inner = M3::Identity();
  switch (joint.kind) {
    case JointKind::fixed: break;
    case JointKind::hinge:
    case JointKind::cylindrical: inner = turn(axis, q[0]); break;
    case JointKind::ball: inner = quaternion(q).toRotationMatrix(); break;
    case JointKind::slider:
    case JointKind::universal: break;
  }
  child.r = parent.r * frame * inner;
  if (joint.kind == JointKind::universal) child.r = parent.r * turn(first, q[0]) * frame * turn(second, q[1]);
  if (joint.kind == JointKind::hinge || joint.kind == JointKind::cylindrical) w_rel = child.r * axis * u[0];
  if (joint.kind == JointKind::universal) w_rel = parent.r * first * u[0] + child.r * second * u[1];
  if (joint.kind == JointKind::ball) w_rel = child.r * v3(u);
  if (joint.kind == JointKind::slider) slide = child.r * axis * q[0], slide_rate = child.r * axis * u[0];
  if (joint.kind == JointKind::cylindrical) slide = child.r * axis * q[1], slide_rate = child.r * axis * u[1];
  child.w = parent.w + w_rel;
  const V3 arm = parent.r * v3(joint.anchors_body_m[0]), reach = child.r * v3(joint.anchors_body_m[1]);
  child.p = parent.p + arm + slide - reach;
  // The slide's axis turns with the parent alone: about itself the child's turn leaves it.
  child.v = parent.v + parent.w.cross(arm) + parent.w.cross(slide) + slide_rate - child.w.cross(reach);
  return child;
}

// Fills in the placed bodies of a scene whose joints stand parents first.
inline void place(Scene& scene) {
  for (const Joint& joint : scene.joints) {
    if (joint.closes_loop) continue;
    const Pose child = child_pose(joint, pose_of(scene, joint.parent), joint.coordinates, joint.rates);
    Body& body = scene.bodies[static_cast<std::size_t>(joint.child)];
    const Eigen::Quaterniond q = Eigen::Quaterniond(child.r).normalized();
    const V3 w = child.r.transpose() * child.w;
    body.position_m = {child.p[0], child.p[1], child.p[2]};
    body.orientation_wxyz = {q.w(), q.x(), q.y(), q.z()};
    body.velocity_m_per_s = {child.v[0], child.v[1], child.v[2]};
    body.angular_velocity_body_rad_per_s = {w[0], w[1], w[2]};
  }
}

// A body with an inertia of three different moments about axes that are not its own.
inline Body oblique_body(const std::string& name, double mass_kg, double turn_rad) {
  Body body = box_body(name, mass_kg, {1, 1, 1});
  const M3 r = turn(V3(1, 2, -1).normalized(), turn_rad);
  const M3 inertia = r * V3(0.11, 0.17, 0.23).asDiagonal() * r.transpose();
  const double xy = inertia(0, 1), xz = inertia(0, 2), yz = inertia(1, 2);
  body.inertia_kg_m2 = {inertia(0, 0), xy, xz, xy, inertia(1, 1), yz, xz, yz, inertia(2, 2)};
  return body;
}

inline Joint joint_of(const std::string& name, JointKind kind, int parent, int child) {
  Joint joint;
  joint.name = name;
  joint.kind = kind;
  joint.parent = parent;
  joint.child = child;
  return joint;
}

// A pendulum about an axis that is neither the body's nor the world's, with a frame that is not the identity.
inline Scene oblique_pendulum() {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0.3, -0.2, -9.81};
  scene.bodies = {oblique_body("bob", 1.7, 0.6)};
  Joint pivot = joint_of("pivot", JointKind::hinge, -1, 0);
  pivot.anchors_body_m = {{{0.2, -0.1, 1.5}, {0.1, 0.25, 0.7}}};
  pivot.axis_body = unit(0.2, 1, -0.3);
  pivot.frame_wxyz = unit(0.9, 0.1, -0.3, 0.2);
  pivot.coordinates[0] = 0.4;
  pivot.rates[0] = 0.7;
  scene.joints = {pivot};
  place(scene);
  return scene;
}

// Two links in a plane: hinges about y, the lower body hangs from the upper one.
inline Scene two_link_arm() {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  scene.bodies = {box_body("upper", 1.2, {0.2, 0.1, 0.15}), box_body("lower", 0.8, {0.05, 0.04, 0.03})};
  Joint shoulder = joint_of("shoulder", JointKind::hinge, -1, 0), elbow = joint_of("elbow", JointKind::hinge, 0, 1);
  shoulder.axis_body = elbow.axis_body = {0, 1, 0};
  shoulder.anchors_body_m = {{{0, 0, 0}, {0, 0, 0.5}}};
  elbow.anchors_body_m = {{{0, 0, -0.5}, {0, 0, 0.4}}};
  shoulder.coordinates[0] = 0.9;
  elbow.coordinates[0] = -1.3;
  shoulder.rates[0] = -0.4;
  elbow.rates[0] = 2.1;
  scene.joints = {shoulder, elbow};
  place(scene);
  return scene;
}

// One joint of each of these kinds in a row below a floating base, with forces along coordinates.
inline Scene zoo(const std::vector<JointKind>& kinds) {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0.5, 0.2, -2};
  Body base = oblique_body("base", 2.5, 0.3);
  base.position_m = {0.3, -0.4, 0.9};
  base.orientation_wxyz = unit(0.8, 0.2, -0.5, 0.1);
  base.velocity_m_per_s = {0.3, 0.1, -0.2};
  base.angular_velocity_body_rad_per_s = {0.5, -0.8, 0.3};
  scene.bodies = {base};
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    const auto n = static_cast<int>(k);
    scene.bodies.push_back(oblique_body("link" + std::to_string(k), 1 + 0.2 * n, 0.4 + n));
    Joint joint = joint_of("joint" + std::to_string(k), kinds[k], n, n + 1);
    joint.anchors_body_m = {{{0.2, 0.1 * n, -0.4}, {-0.1, 0.15, 0.3}}};
    joint.frame_wxyz = unit(0.9, 0.3 - 0.1 * n, 0.2, -0.1 * n);
    joint.axis_body = unit(0.4, -0.2 * n, 0.7);
    if (joint.kind == JointKind::universal) {
      joint.axes_body[1] = unit(0.3, 0.5, -0.8);
      const V3 second = quaternion(joint.frame_wxyz) * v3(joint.axes_body[1]);
      const V3 first = second.cross(V3(0.1, 0.9, 0.2)).normalized();
      joint.axes_body[0] = {first[0], first[1], first[2]};
    }
    joint.coordinates = {0.3 - 0.1 * n, 0.15, 0, 0};
    if (joint.kind == JointKind::ball) joint.coordinates = unit(0.8, -0.3, 0.2, 0.4);
    joint.rates = {0.4, -0.6, 0.9};
    scene.joints.push_back(joint);
    if (kinds[k] == JointKind::fixed) continue;
    scene.joint_forces.push_back(JointSpring{n, 0, kinds[k] == JointKind::ball ? 0 : 1.5, 0.2, 0.3});
    if (coordinate_count(kinds[k]) == 2) scene.joint_forces.push_back(JointSpring{n, 1, 2.5, -0.1, 0.1});
    if (kinds[k] != JointKind::ball) scene.joint_forces.push_back(JointTorque{n, 0, 0.4, 3.0, 0.5, {}});
  }
  place(scene);
  return scene;
}

// Of the kind, between the world and a placed body at rest, that closes a loop.
inline Joint closing_joint(const Scene& scene, JointKind kind, int child) {
  Joint last = joint_of("closing", kind, -1, child);
  last.closes_loop = true;
  last.axis_body = unit(0.1, 0.7, 0.4);
  last.anchors_body_m[1] = {0.2, -0.3, 0.1};
  const Pose link = pose_of(scene, child);
  const V3 at = link.p + link.r * v3(last.anchors_body_m[1]);
  last.anchors_body_m[0] = {at[0], at[1], at[2]};
  last.frame_wxyz = scene.bodies[static_cast<std::size_t>(child)].orientation_wxyz;
  last.axes_body[1] = unit(0.3, 0.5, -0.8);
  const V3 first = (link.r * v3(last.axes_body[1])).cross(V3(0.1, 0.9, 0.2)).normalized();
  last.axes_body[0] = {first[0], first[1], first[2]};
  if (kind == JointKind::ball) last.coordinates = {1, 0, 0, 0};
  return last;
}

}  // namespace atwood::test
