#include "closed_form/mechanism.hpp"

#include <algorithm>

#include "scene/mechanism.hpp"

namespace atwood::closed_form {

namespace {

template <class S> BodyKinematics<S> at_rest(const Body& body) {
  BodyKinematics<S> made;
  made.pose = initial_pose<S>(body);
  return made;
}

// Orientation of the child in the parent.
template <class S> Quat<S> relative_orientation(const Joint& joint, const JointState<S>& state) {
  const Quat<S> frame = quat<S>(joint.frame_wxyz);
  switch (joint.kind) {
    case JointKind::fixed:
    case JointKind::slider: return frame;
    case JointKind::hinge:
    case JointKind::cylindrical: return frame * turn(unit<S>(joint.axis_body), state.q[0]);
    case JointKind::universal:
      return turn(unit<S>(joint.axes_body[0]), state.q[0]) * frame * turn(unit<S>(joint.axes_body[1]), state.q[1]);
    case JointKind::ball: return frame * Quat<S>(state.q);
  }
  return frame;
}

template <class S> bool has_angle(const Joint& joint) {
  return joint.kind == JointKind::hinge || joint.kind == JointKind::cylindrical;
}

// With n the axis (fixed in the child), s the slide, r the anchors, all in world axes:
//   p_child = p_parent + r_parent + n s - r_child
// and its derivatives, where each vector turns with its body.
template <class S>
BodyKinematics<S> place_child(const Joint& joint, const JointState<S>& state, const BodyKinematics<S>& parent) {
  BodyKinematics<S> child;
  const Quat<S>& q_P = parent.pose.q_WB;
  const Quat<S> q_C = child.pose.q_WB = q_P * relative_orientation(joint, state);
  Vec<S> w = parent.w_W, alpha = parent.alpha_W;
  const auto turn_about = [&](const Vec<S>& n, const Vec<S>& w_of_n, S rate, S change) {
    w = w + rate * n;
    alpha = alpha + rate * cross(w_of_n, n) + change * n;
  };
  const bool slides = joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical;
  Vec<S> n{};
  if (slides || joint.kind == JointKind::hinge) n = rotate(q_C, unit<S>(joint.axis_body));
  if (has_angle<S>(joint)) turn_about(n, parent.w_W, state.u[0], state.du[0]);
  if (joint.kind == JointKind::universal) {
    turn_about(rotate(q_P, unit<S>(joint.axes_body[0])), parent.w_W, state.u[0], state.du[0]);
    turn_about(rotate(q_C, unit<S>(joint.axes_body[1])), w, state.u[1], state.du[1]);
  }
  if (joint.kind == JointKind::ball) {
    const Vec<S> relative = rotate(q_C, state.u);
    alpha = alpha + cross(w, relative) + rotate(q_C, state.du);  // w + relative is the child's; relative x itself is 0
    w = w + relative;
  }
  child.w_W = w;
  child.alpha_W = alpha;
  child.pose.w_WB_B = rotate(conjugate(q_C), w);
  const auto at = [](const Vec<S>& spin, const Vec<S>& change, const Vec<S>& r) {
    return cross(change, r) + cross(spin, cross(spin, r));
  };
  const Vec<S> r_P = rotate(q_P, vec<S>(joint.anchors_body_m[0])), r_C = rotate(q_C, vec<S>(joint.anchors_body_m[1]));
  child.pose.p_WB = parent.pose.p_WB + r_P - r_C;
  child.pose.v_WB = parent.pose.v_WB + cross(parent.w_W, r_P) - cross(w, r_C);
  child.a_W = parent.a_W + at(parent.w_W, parent.alpha_W, r_P) - at(w, alpha, r_C);
  if (slides) {
    const int which = joint.kind == JointKind::cylindrical ? 1 : 0;
    const S s = state.q[which], u = state.u[which], du = state.du[which];
    child.pose.p_WB = child.pose.p_WB + s * n;
    child.pose.v_WB = child.pose.v_WB + u * n + s * cross(w, n);
    child.a_W = child.a_W + du * n + S(2) * u * cross(w, n) + s * at(w, alpha, n);
  }
  return child;
}

}  // namespace

template <class S> Vec<S> unit(const Real3& given) {
  const Vec<S> v = vec<S>(given);
  return (1 / norm(v)) * v;
}

bool is_grounded(const Scene& scene, const Joint& joint) {
  return joint.parent < 0 || scene.bodies[static_cast<std::size_t>(joint.parent)].fixed;
}

std::string not_a_tree(const Scene& scene) {
  std::vector<int> placed(scene.bodies.size(), 0);
  for (const Joint& joint : scene.joints)
    if (!joint.closes_loop) ++placed[static_cast<std::size_t>(joint.child)];
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.fixed ? placed[i] != 0 : placed[i] != 1)
      return "`" + body.name + "` is placed by " + std::to_string(placed[i]) + " joints";
    if (!body.fixed && !rotates(body)) return "`" + body.name + "` is a point mass with a joint";
  }
  return possible_contact(scene);
}

template <class S> JointState<S> initial_joint(const Joint& joint) {
  JointState<S> made;
  for (std::size_t k = 0; k < 4; ++k) made.q[k] = joint.coordinates[k];
  for (std::size_t k = 0; k < 3; ++k) made.u[k] = joint.rates[k];
  if (joint.kind == JointKind::ball) made.q = quat<S>(joint.coordinates);
  if (joint.driven_rate) made.u[0] = *joint.driven_rate;
  return made;
}

template <class S>
std::vector<BodyKinematics<S>> place_bodies(const Scene& scene, const std::vector<JointState<S>>& joints) {
  std::vector<BodyKinematics<S>> made;
  std::vector<bool> placed(scene.bodies.size(), true);
  for (const Body& body : scene.bodies) made.push_back(at_rest<S>(body));
  for (const Joint& joint : scene.joints)
    if (!joint.closes_loop) placed[static_cast<std::size_t>(joint.child)] = false;
  const BodyKinematics<S> world;
  for (bool moved = true; moved;) {  // joints may stand in any order
    moved = false;
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const Joint& joint = scene.joints[j];
      const auto child = static_cast<std::size_t>(joint.child);
      if (joint.closes_loop || placed[child]) continue;
      if (joint.parent >= 0 && !placed[static_cast<std::size_t>(joint.parent)]) continue;
      const BodyKinematics<S>& parent = joint.parent < 0 ? world : made[static_cast<std::size_t>(joint.parent)];
      made[child] = place_child(joint, joints[j], parent);
      placed[child] = moved = true;
    }
  }
  return made;
}

template <class S> std::string start_joints(const Scene& scene, std::vector<JointState<S>>& joints) {
  try {
    const MechanismStart start = mechanism_start(scene);
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      JointState<S>& made = joints.emplace_back();
      for (std::size_t k = 0; k < 4; ++k) made.q[k] = S(start.joints[j].q[k]);
      for (std::size_t k = 0; k < 3; ++k) made.u[k] = S(start.joints[j].u[k]);
    }
  } catch (const MechanismError& error) {
    return error.what();
  }
  return "";
}

int moving_body(const Scene& scene, int body) {
  return body < 0 || scene.bodies[static_cast<std::size_t>(body)].fixed ? -1 : body;
}

template <class S> S sign_along(const Joint& joint, const std::vector<BodyKinematics<S>>& bodies, const Vec<S>& n) {
  const Vec<S> axis = rotate(bodies[static_cast<std::size_t>(joint.child)].pose.q_WB, unit<S>(joint.axis_body));
  if (norm(cross(axis, n)) > 256 * unit_round_off<S>()) return 0;
  return dot(axis, n) < 0 ? -1 : 1;
}

template <class S> Vec<S> anchor_at(const Joint& joint, int end, const std::vector<BodyKinematics<S>>& bodies) {
  const int body = end == 0 ? joint.parent : joint.child;
  const Vec<S> at = vec<S>(joint.anchors_body_m[static_cast<std::size_t>(end)]);
  if (body < 0) return at;
  const Pose<S>& pose = bodies[static_cast<std::size_t>(body)].pose;
  return pose.p_WB + rotate(pose.q_WB, at);
}

template <class S> S applied_at(const Scene& scene, int joint, int coordinate, S q, S u, S t_s) {
  S sum = 0;
  for (const JointForce& force : scene.joint_forces) {
    if (const auto* spring = std::get_if<JointSpring>(&force)) {
      if (spring->joint == joint && spring->coordinate == coordinate)
        sum -= S(spring->stiffness) * (q - S(spring->rest)) + S(spring->damping) * u;
      continue;
    }
    const auto& motor = std::get<JointTorque>(force);
    if (motor.joint == joint && motor.coordinate == coordinate)
      sum += S(motor.torque) * cos(S(motor.angular_frequency_rad_per_s) * t_s + S(motor.phase_rad));
  }
  return sum;
}

template Vec<Narrow> unit(const Real3&);
template Vec<Wide> unit(const Real3&);
template JointState<Narrow> initial_joint(const Joint&);
template JointState<Wide> initial_joint(const Joint&);
template std::string start_joints(const Scene&, std::vector<JointState<Narrow>>&);
template std::string start_joints(const Scene&, std::vector<JointState<Wide>>&);
template Narrow sign_along(const Joint&, const std::vector<BodyKinematics<Narrow>>&, const Vec<Narrow>&);
template Wide sign_along(const Joint&, const std::vector<BodyKinematics<Wide>>&, const Vec<Wide>&);
template Vec<Narrow> anchor_at(const Joint&, int, const std::vector<BodyKinematics<Narrow>>&);
template Vec<Wide> anchor_at(const Joint&, int, const std::vector<BodyKinematics<Wide>>&);
template Narrow applied_at(const Scene&, int, int, Narrow, Narrow, Narrow);
template Wide applied_at(const Scene&, int, int, Wide, Wide, Wide);
template std::vector<BodyKinematics<Narrow>> place_bodies(const Scene&, const std::vector<JointState<Narrow>>&);
template std::vector<BodyKinematics<Wide>> place_bodies(const Scene&, const std::vector<JointState<Wide>>&);

}  // namespace atwood::closed_form
