#include "rivals/joints.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "rivals/vector.hpp"

namespace atwood::rivals {
namespace {

// Of a unit quaternion that is a rotation about this axis; in [-pi, pi].
double angle_about(const Real3& axis, const Real4& q) {
  const double sine = q[1] * axis[0] + q[2] * axis[1] + q[3] * axis[2];
  return q[0] < 0 ? 2 * std::atan2(-sine, -q[0]) : 2 * std::atan2(sine, q[0]);
}

// From vector a to vector b, both orthogonal to the unit axis.
double angle_from_to(const Real3& axis, const Real3& a, const Real3& b) {
  return std::atan2(dot(axis, cross(a, b)), dot(a, b));
}

bool is_on(const std::vector<Interval>& on_s, double t_s) {
  return on_s.empty() ||
         std::any_of(on_s.begin(), on_s.end(), [&](const Interval& on) { return on.from_s <= t_s && t_s < on.to_s; });
}

// Coordinates that are angles: the first `count` of them.
int angle_count(JointKind kind) {
  return kind == JointKind::universal ? 2 : kind == JointKind::hinge || kind == JointKind::cylindrical ? 1 : 0;
}

}  // namespace

std::vector<int> placing_joints(const Scene& scene) {
  std::vector<int> placing(scene.bodies.size(), -1);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    if (!joint.closes_loop) placing[static_cast<std::size_t>(joint.child)] = static_cast<int>(j);
  }
  return placing;
}

std::vector<int> parents_first(const Scene& scene) {
  const std::vector<int> placing = placing_joints(scene);
  std::vector<int> order;
  std::vector<bool> listed(scene.bodies.size(), false);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    std::vector<int> path;
    for (int b = static_cast<int>(i); b >= 0 && !listed[static_cast<std::size_t>(b)];) {
      path.push_back(b);
      listed[static_cast<std::size_t>(b)] = true;
      const int joint = placing[static_cast<std::size_t>(b)];
      b = joint < 0 ? -1 : scene.joints[static_cast<std::size_t>(joint)].parent;
    }
    order.insert(order.end(), path.rbegin(), path.rend());
  }
  return order;
}

bool joined(const Scene& scene, int body_a, int body_b) {
  return std::any_of(scene.joints.begin(), scene.joints.end(), [&](const Joint& joint) {
    return (joint.parent == body_a && joint.child == body_b) || (joint.parent == body_b && joint.child == body_a);
  });
}

Motion motion_at_start(const Scene& scene, int body) {
  if (body < 0) return {};
  const Body& b = scene.bodies[static_cast<std::size_t>(body)];
  return {b.position_m, b.orientation_wxyz, b.velocity_m_per_s, b.angular_velocity_body_rad_per_s};
}

JointPlace place_of(const Joint& joint, const Motion& parent, const Motion& child) {
  JointPlace place;
  place.parent_anchor_m = parent.p_WB + to_world(parent.q_WB, joint.anchors_body_m[0]);
  place.child_anchor_m = child.p_WB + to_world(child.q_WB, joint.anchors_body_m[1]);
  if (joint.kind == JointKind::universal) {
    place.axes = {to_world(parent.q_WB, joint.axes_body[0]), to_world(child.q_WB, joint.axes_body[1])};
  } else if (joint.kind != JointKind::ball && joint.kind != JointKind::fixed) {
    place.axes[0] = to_world(child.q_WB, joint.axis_body);
  }
  return place;
}

// Q = F^T R_parent^T R_child as a quaternion is exp(axis q0) of a hinge and Q(q) of a ball. The slide s = axis . d with
// the axis fixed in the child: s' = axis . (d' - w_child x d).
JointState state_from_motions(const Joint& joint, const Motion& parent, const Motion& child) {
  JointState state;
  const JointPlace place = place_of(joint, parent, child);
  const Real4 turn = product(conjugate(joint.frame_wxyz), product(conjugate(parent.q_WB), child.q_WB));
  const Real3 w_parent = to_world(parent.q_WB, parent.w_WB_B), w_child = to_world(child.q_WB, child.w_WB_B);
  const Real3 w_rel = w_child - w_parent;
  const Real3& axis = place.axes[0];
  const auto slide = [&](double& q, double& u) {
    const Real3 d = place.child_anchor_m - place.parent_anchor_m;
    const Real3 v_child = child.v_WB + cross(w_child, place.child_anchor_m - child.p_WB);
    const Real3 v_parent = parent.v_WB + cross(w_parent, place.parent_anchor_m - parent.p_WB);
    q = dot(axis, d);
    u = dot(axis, v_child - v_parent - cross(w_child, d));
  };
  switch (joint.kind) {
    case JointKind::fixed: break;
    case JointKind::slider: slide(state.q[0], state.u[0]); break;
    case JointKind::cylindrical: slide(state.q[1], state.u[1]); [[fallthrough]];
    case JointKind::hinge:
      state.q[0] = angle_about(joint.axis_body, turn);
      state.u[0] = dot(axis, w_rel);
      break;
    case JointKind::universal: {
      const Real3 second_at_zero = to_world(parent.q_WB, to_world(joint.frame_wxyz, joint.axes_body[1]));
      const Real3 first_in_child = to_body(child.q_WB, place.axes[0]);
      const Real3 first_at_zero = to_body(joint.frame_wxyz, joint.axes_body[0]);
      state.q[0] = angle_from_to(place.axes[0], second_at_zero, place.axes[1]);
      state.q[1] = angle_from_to(joint.axes_body[1], first_in_child, first_at_zero);
      for (int k = 0; k < 2; ++k) state.u[k] = dot(place.axes[k], w_rel);
      break;
    }
    case JointKind::ball:
      state.q = turn;
      state.u = to_body(child.q_WB, w_rel);
      break;
  }
  return state;
}

void continue_coordinates(JointKind kind, const JointState& last, JointState& now) {
  constexpr double full_turn = 2 * std::numbers::pi;
  for (int k = 0; k < angle_count(kind); ++k) now.q[k] += full_turn * std::round((last.q[k] - now.q[k]) / full_turn);
  if (kind != JointKind::ball) return;
  double same_sign = 0;
  for (int k = 0; k < 4; ++k) same_sign += last.q[k] * now.q[k];
  if (same_sign < 0)
    for (double& q : now.q) q = -q;
}

PassiveForce passive_force(const Scene& scene, int joint, int coordinate) {
  PassiveForce sum;
  double moment = 0;
  for (const JointForce& force : scene.joint_forces) {
    const auto* spring = std::get_if<JointSpring>(&force);
    if (!spring || spring->joint != joint || spring->coordinate != coordinate) continue;
    sum.stiffness += spring->stiffness;
    sum.damping += spring->damping;
    moment += spring->stiffness * spring->rest;
    sum.rest = spring->rest;  // of a single spring: exactly its own
  }
  if (sum.stiffness > 0 && moment != sum.stiffness * sum.rest) sum.rest = moment / sum.stiffness;
  return sum;
}

std::vector<Real3> motor_efforts(const Scene& scene, double t_s, double t_switch_s) {
  std::vector<Real3> efforts(scene.joints.size());
  for (const JointForce& force : scene.joint_forces) {
    const auto* motor = std::get_if<JointTorque>(&force);
    if (!motor || !is_on(motor->on_s, t_switch_s)) continue;
    efforts[static_cast<std::size_t>(motor->joint)][motor->coordinate] +=
        motor->torque * std::cos(motor->angular_frequency_rad_per_s * t_s + motor->phase_rad);
  }
  return efforts;
}

std::vector<Real3> joint_efforts(const Scene& scene, double t_s, double t_switch_s,
                                 const std::vector<JointState>& states) {
  std::vector<Real3> efforts = motor_efforts(scene, t_s, t_switch_s);
  for (const JointForce& force : scene.joint_forces) {
    const auto* spring = std::get_if<JointSpring>(&force);
    if (!spring) continue;
    const auto j = static_cast<std::size_t>(spring->joint);
    const JointState& state = states[j];
    if (scene.joints[j].kind == JointKind::ball) {
      add(efforts[j], -spring->damping * state.u);
    } else {
      const int k = spring->coordinate;
      efforts[j][k] -= spring->stiffness * (state.q[k] - spring->rest) + spring->damping * state.u[k];
    }
  }
  return efforts;
}

void add_joint_wrenches(const Scene& scene, const std::vector<Motion>& motions, const std::vector<Real3>& efforts,
                        std::vector<Wrench>& wrenches) {
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    if (efforts[j] == Real3{}) continue;
    const Joint& joint = scene.joints[j];
    const Motion parent = motion_of(motions, joint.parent), child = motion_of(motions, joint.child);
    const JointPlace place = place_of(joint, parent, child);
    Real3 force{}, torque{};
    switch (joint.kind) {
      case JointKind::fixed: break;
      case JointKind::hinge: torque = efforts[j][0] * place.axes[0]; break;
      case JointKind::slider: force = efforts[j][0] * place.axes[0]; break;
      case JointKind::cylindrical:
        torque = efforts[j][0] * place.axes[0];
        force = efforts[j][1] * place.axes[0];
        break;
      case JointKind::universal: torque = efforts[j][0] * place.axes[0] + efforts[j][1] * place.axes[1]; break;
      case JointKind::ball: torque = to_world(child.q_WB, efforts[j]); break;
    }
    Wrench& on_child = wrenches[static_cast<std::size_t>(joint.child)];
    add(on_child.force_N, force);
    add(on_child.torque_N_m, torque + cross(place.child_anchor_m - child.p_WB, force));
    if (joint.parent < 0) continue;
    Wrench& on_parent = wrenches[static_cast<std::size_t>(joint.parent)];
    add(on_parent.force_N, -1.0 * force);
    add(on_parent.torque_N_m, -1.0 * (torque + cross(place.child_anchor_m - parent.p_WB, force)));
  }
}

// The two axes of a universal joint are orthogonal, so that the constraint's torque is along their cross product.
Reaction constraint_part(const Joint& joint, const JointPlace& place, const Reaction& total) {
  Reaction part = total;
  if (joint.driven_rate) return part;
  const Real3& axis = place.axes[0];
  const auto drop = [&](Real3& v) { v = v - dot(axis, v) * axis; };
  switch (joint.kind) {
    case JointKind::fixed: break;
    case JointKind::hinge: drop(part.torque_N_m); break;
    case JointKind::slider: drop(part.force_N); break;
    case JointKind::cylindrical:
      drop(part.force_N);
      drop(part.torque_N_m);
      break;
    case JointKind::universal: {
      const Real3 normal = cross(place.axes[0], place.axes[1]);
      part.torque_N_m = (dot(normal, total.torque_N_m) / dot(normal, normal)) * normal;
      break;
    }
    case JointKind::ball: part.torque_N_m = {}; break;
  }
  return part;
}

std::vector<Reaction> subtree_reactions(const Scene& scene, const std::vector<Motion>& motions,
                                        std::vector<Wrench> missing, std::vector<Reaction> reactions) {
  const std::vector<int> placing = placing_joints(scene), order = parents_first(scene);
  for (auto body = order.rbegin(); body != order.rend(); ++body) {
    const auto i = static_cast<std::size_t>(*body);
    if (placing[i] < 0) continue;
    const Joint& joint = scene.joints[static_cast<std::size_t>(placing[i])];
    const Motion parent = motion_of(motions, joint.parent);
    const JointPlace place = place_of(joint, parent, motions[i]);
    const Real3 arm = place.child_anchor_m - motions[i].p_WB;
    const Reaction total{missing[i].force_N, missing[i].torque_N_m - cross(arm, missing[i].force_N)};
    reactions[static_cast<std::size_t>(placing[i])] = constraint_part(joint, place, total);
    if (joint.parent < 0) continue;
    Wrench& of_parent = missing[static_cast<std::size_t>(joint.parent)];
    add(of_parent.force_N, total.force_N);
    add(of_parent.torque_N_m, total.torque_N_m + cross(place.child_anchor_m - parent.p_WB, total.force_N));
  }
  return reactions;
}

std::string names_of_joint_forces(const Scene& scene) {
  std::set<std::string> names;
  for (const JointForce& force : scene.joint_forces)
    names.insert(std::holds_alternative<JointSpring>(force) ? "joint-spring" : "joint-torque");
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

int turning_point_mass(const Scene& scene) {
  const std::vector<int> placing = placing_joints(scene);
  std::vector<bool> turns(scene.bodies.size(), false);
  for (const int b : parents_first(scene)) {
    const auto i = static_cast<std::size_t>(b);
    const Body& body = scene.bodies[i];
    if (placing[i] < 0) {
      turns[i] = !body.fixed && rotates(body);
      continue;
    }
    const Joint& joint = scene.joints[static_cast<std::size_t>(placing[i])];
    const bool keeps_attitude = joint.kind == JointKind::fixed || joint.kind == JointKind::slider;
    turns[i] = !keeps_attitude || (joint.parent >= 0 && turns[static_cast<std::size_t>(joint.parent)]);
    if (turns[i] && !rotates(body)) return b;
  }
  return -1;
}

int jointed_point_mass(const Scene& scene) {
  const std::vector<int> placing = placing_joints(scene);
  for (const Joint& joint : scene.joints)
    for (const int b : {joint.parent, joint.child}) {
      if (b < 0 || placing[static_cast<std::size_t>(b)] >= 0) continue;
      const Body& body = scene.bodies[static_cast<std::size_t>(b)];
      if (!body.fixed && !rotates(body)) return b;
    }
  return -1;
}

}  // namespace atwood::rivals
