// Loops for tests: closed at random, settled onto their constraints, and closed by another of their joints.
#pragma once

#include <cmath>

#include "random_mechanism.hpp"
#include "scene/mechanism.hpp"

namespace atwood {

// The scene with its start moved onto the constraints and rounded.
inline Scene settled(const Scene& scene) {
  const MechanismStart start = mechanism_start(scene);
  Scene made = scene;
  const auto narrow = [](const auto& from, auto& to) {
    for (std::size_t k = 0; k < to.size(); ++k) to[k] = static_cast<double>(from[k]);
  };
  for (std::size_t i = 0; i < made.bodies.size(); ++i) {
    if (made.bodies[i].fixed) continue;
    narrow(start.bodies[i].p_m, made.bodies[i].position_m);
    narrow(start.bodies[i].q_wxyz, made.bodies[i].orientation_wxyz);
    narrow(start.bodies[i].v_m_per_s, made.bodies[i].velocity_m_per_s);
    narrow(start.bodies[i].w_rad_per_s, made.bodies[i].angular_velocity_body_rad_per_s);
  }
  for (std::size_t j = 0; j < made.joints.size(); ++j) {
    narrow(start.joints[j].q, made.joints[j].coordinates);
    narrow(start.joints[j].u, made.joints[j].rates);
  }
  return made;
}

// The same mechanism with the joint `closing` in the tree and `placing`, which placed its child, closing the loop.
// `scene` is settled.
inline Scene exchanged(Scene scene, int closing, int placing) {
  std::swap(scene.joints[static_cast<std::size_t>(closing)].closes_loop,
            scene.joints[static_cast<std::size_t>(placing)].closes_loop);
  std::swap(scene.joints[static_cast<std::size_t>(closing)].assemble,
            scene.joints[static_cast<std::size_t>(placing)].assemble);
  return scene;
}

// Ties the last body of the tree to an earlier one by a joint of the kind, whose coordinates are 0 at the start,
// with a spring and a motor along each of its rates (a ball: a damper). False: they are one body.
inline bool close_a_loop(Scene& scene, Draw& draw, JointKind kind) {
  const MechanismStart at = mechanism_start(scene);
  const int last = scene.joints.back().child, first = scene.joints.front().child;
  if (first == last) return false;
  Joint closing = random_joint(draw, kind, first, last);
  closing.name = "closing";
  closing.closes_loop = closing.assemble = true;
  closing.coordinates = {kind == JointKind::ball ? 1.0 : 0.0, 0, 0, 0};
  const auto turned = [](const auto& q, const Real3& v, bool back) {
    const double w = static_cast<double>(q[0]), s = back ? -1 : 1;
    const double u[3] = {s * static_cast<double>(q[1]), s * static_cast<double>(q[2]), s * static_cast<double>(q[3])};
    const auto cross = [](const double* a, const double* b) {
      return Real3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    Real3 inner = cross(u, v.data());
    for (int k = 0; k < 3; ++k) inner[k] += w * v[k];
    const Real3 outer = cross(u, inner.data());
    return Real3{v[0] + 2 * outer[0], v[1] + 2 * outer[1], v[2] + 2 * outer[2]};
  };
  const auto &q_first = at.bodies[first].q_wxyz, &q_last = at.bodies[last].q_wxyz;
  const Real3 arm = turned(q_first, closing.anchors_body_m[0], false);
  Real3 from_last;
  for (int k = 0; k < 3; ++k)
    from_last[k] = static_cast<double>(at.bodies[first].p_m[k]) + arm[k] - static_cast<double>(at.bodies[last].p_m[k]);
  closing.anchors_body_m[1] = turned(q_last, from_last, true);
  // The frame: from the axes of the first body to those of the last.
  const auto frame = quad::product(quad::conjugate(q_first), q_last);
  for (std::size_t k = 0; k < 4; ++k) closing.frame_wxyz[k] = static_cast<double>(frame[k]);
  if (kind == JointKind::universal) {  // the first axis across the second
    const Real3 a2 = turned(closing.frame_wxyz, closing.axes_body[1], false), b = draw.direction();
    Real3 a1{a2[1] * b[2] - a2[2] * b[1], a2[2] * b[0] - a2[0] * b[2], a2[0] * b[1] - a2[1] * b[0]};
    const double length = std::sqrt(a1[0] * a1[0] + a1[1] * a1[1] + a1[2] * a1[2]);
    for (double& part : a1) part /= length;
    closing.axes_body[0] = a1;
  }
  scene.joints.push_back(closing);
  const int joint = static_cast<int>(scene.joints.size()) - 1;
  if (kind == JointKind::ball) {
    scene.joint_forces.emplace_back(JointSpring{joint, 0, 0, 0, draw.uniform(0.5, 2)});
    return true;
  }
  for (int k = 0; k < rate_count(kind); ++k) {
    scene.joint_forces.emplace_back(
        JointSpring{joint, k, draw.uniform(5, 20), draw.uniform(-1, 1), draw.uniform(0.5, 2)});
    scene.joint_forces.emplace_back(JointTorque{joint, k, draw.uniform(-3, 3), 2, 0.3, {}});
  }
  return true;
}

}  // namespace atwood
