#include "scene/mechanism.hpp"

#include "scene/loop_projection.hpp"

namespace atwood {

using namespace quad;

namespace {

const Real kPi = acosq(Real(-1));

Vector vector_part(const Quaternion& q) { return {q[1], q[2], q[3]}; }

Quaternion frame_of(const Joint& joint) { return normalised(wide(joint.frame_wxyz)); }
Vector axis_of(const Joint& joint) { return unit(wide(joint.axis_body)); }

// The orientation of the child in the parent's axes.
Quaternion relative_orientation(const Joint& joint, const Quaternion& q) {
  const Quaternion frame = frame_of(joint);
  switch (joint.kind) {
    case JointKind::fixed:
    case JointKind::slider: return frame;
    case JointKind::hinge:
    case JointKind::cylindrical: return product(frame, turn(axis_of(joint), q[0]));
    case JointKind::universal:
      return product(product(turn(unit(wide(joint.axes_body[0])), q[0]), frame),
                     turn(unit(wide(joint.axes_body[1])), q[1]));
    case JointKind::ball: return product(frame, normalised(q));
  }
  return frame;
}

// The offset of the child's anchor from the parent's and its rate in the child's axes, along the axis.
struct Slide {
  Real offset = 0, rate = 0;
};
Slide slide_of(const Joint& joint, const JointMotion& motion) {
  if (joint.kind == JointKind::slider) return {motion.q[0], motion.u[0]};
  if (joint.kind == JointKind::cylindrical) return {motion.q[1], motion.u[1]};
  return {};
}

// w_child - R_child^T w_parent (world axes) from the rates, in the child's axes.
Vector relative_body_rate(const Joint& joint, const JointMotion& motion) {
  switch (joint.kind) {
    case JointKind::fixed:
    case JointKind::slider: return {};
    case JointKind::hinge:
    case JointKind::cylindrical: return motion.u[0] * axis_of(joint);
    case JointKind::universal: {
      // R_rel = exp(a1 q0) F exp(a2 q1): the first rate turns about exp(-a2 q1) F^T a1 in the child's axes.
      const Vector a2 = unit(wide(joint.axes_body[1]));
      const Vector first = rotate_back(product(frame_of(joint), turn(a2, motion.q[1])), unit(wide(joint.axes_body[0])));
      return motion.u[0] * first + motion.u[1] * a2;
    }
    case JointKind::ball: return motion.u;
  }
  return {};
}

// The angle about the unit vector `axis` from a to b, both orthogonal to it, next to `near`.
Real angle_between(const Vector& axis, const Vector& a, const Vector& b, Real near) {
  const Real angle = atan2q(dot(axis, cross(a, b)), dot(a, b));
  return angle + 2 * kPi * roundq((near - angle) / (2 * kPi));
}

// q of R_rel = F exp(axis q), next to `near`.
Real angle_about(const Vector& axis, const Quaternion& turned, Real near) {
  const Real angle = 2 * atan2q(dot(axis, vector_part(turned)), turned[0]);
  return angle + 2 * kPi * roundq((near - angle) / (2 * kPi));
}

void universal_motion(const Joint& joint, const Quaternion& relative, const Vector& w_rel, const JointMotion& near,
                      JointMotion& out) {
  const Vector a1 = unit(wide(joint.axes_body[0])), a2 = unit(wide(joint.axes_body[1]));
  const Quaternion frame = frame_of(joint);
  const auto across = [](const Vector& axis, const Vector& v) { return v - dot(axis, v) * axis; };
  out.q[0] = angle_between(a1, across(a1, rotate(frame, a2)), across(a1, rotate(relative, a2)), near.q[0]);
  out.q[1] = -angle_between(a2, across(a2, rotate_back(frame, a1)), across(a2, rotate_back(relative, a1)), -near.q[1]);
  const Vector first = rotate_back(product(frame, turn(a2, out.q[1])), a1);
  // The axes are orthogonal to 1e-9 only: w_rel = u0 first + u1 a2 is solved as it stands.
  const Real cosine = dot(first, a2), square = 1 - cosine * cosine;
  out.u[0] = (dot(first, w_rel) - cosine * dot(a2, w_rel)) / square;
  out.u[1] = (dot(a2, w_rel) - cosine * dot(first, w_rel)) / square;
}

[[noreturn]] void fail_cycle(const Scene& scene, const std::vector<bool>& ordered) {
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (!scene.joints[j].closes_loop && !ordered[j])
      throw MechanismError("joint `" + scene.joints[j].name +
                               "` is part of a cycle of joints that place each other's bodies; expected a tree, and "
                               "closes_loop = true on the joint that closes the cycle",
                           static_cast<int>(j));
  throw MechanismError("found joints in a cycle", -1);
}

void check_indices(const Scene& scene, std::size_t j) {
  const Joint& joint = scene.joints[j];
  const auto bodies = static_cast<int>(scene.bodies.size());
  const auto at = static_cast<int>(j);
  if (joint.parent < -1 || joint.parent >= bodies || joint.child < 0 || joint.child >= bodies)
    throw MechanismError("joint `" + joint.name + "` names a body that is not there", at);
  if (joint.parent == joint.child)
    throw MechanismError("joint `" + joint.name + "` ties a body to itself; expected two bodies", at);
}

}  // namespace

BodyMotion world_motion() { return {}; }

const BodyMotion& motion_of(const std::vector<BodyMotion>& bodies, int body, const BodyMotion& world) {
  return body < 0 ? world : bodies[static_cast<std::size_t>(body)];
}

std::vector<int> placing_joints(const Scene& scene) {
  std::vector<int> placing(scene.bodies.size(), -1);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    check_indices(scene, j);
    const Joint& joint = scene.joints[j];
    if (joint.closes_loop) continue;
    int& place = placing[static_cast<std::size_t>(joint.child)];
    if (place >= 0)
      throw MechanismError("joint `" + joint.name + "` places the body `" +
                               scene.bodies[static_cast<std::size_t>(joint.child)].name + "`, which the joint `" +
                               scene.joints[static_cast<std::size_t>(place)].name +
                               "` places already; expected one placing joint for each body, and closes_loop = true on "
                               "the others",
                           static_cast<int>(j));
    place = static_cast<int>(j);
  }
  return placing;
}

std::vector<int> joints_from_root(const Scene& scene) {
  const std::vector<int> placing = placing_joints(scene);
  std::vector<std::vector<int>> children(scene.bodies.size());
  std::vector<int> order;
  std::vector<bool> ordered(scene.joints.size());
  std::size_t tree_joints = 0;
  const auto append = [&](std::size_t j) {
    order.push_back(static_cast<int>(j));
    ordered[j] = true;
  };
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    if (joint.closes_loop) continue;
    ++tree_joints;
    if (joint.parent < 0 || placing[static_cast<std::size_t>(joint.parent)] < 0) append(j);
    else children[static_cast<std::size_t>(joint.parent)].push_back(static_cast<int>(j));
  }
  for (std::size_t next = 0; next < order.size(); ++next) {
    const int body = scene.joints[static_cast<std::size_t>(order[next])].child;
    for (const int j : children[static_cast<std::size_t>(body)]) append(static_cast<std::size_t>(j));
  }
  if (order.size() != tree_joints) fail_cycle(scene, ordered);
  return order;
}

std::vector<BodyMotion> given_motions(const Scene& scene) {
  const std::vector<int> placing = placing_joints(scene);
  std::vector<BodyMotion> motions(scene.bodies.size());
  for (std::size_t b = 0; b < motions.size(); ++b) {
    if (placing[b] >= 0) continue;
    const Body& body = scene.bodies[b];
    motions[b] = {wide(body.position_m), normalised(wide(body.orientation_wxyz)), wide(body.velocity_m_per_s),
                  wide(body.angular_velocity_body_rad_per_s)};
  }
  return motions;
}

std::vector<JointMotion> given_joint_motions(const Scene& scene) {
  std::vector<JointMotion> motions;
  motions.reserve(scene.joints.size());
  for (const Joint& joint : scene.joints) {
    JointMotion motion{wide(joint.coordinates), wide(joint.rates)};
    if (joint.kind == JointKind::ball) {
      if (joint.coordinates == std::array<double, 4>{}) motion.q = {1, 0, 0, 0};
      motion.q = normalised(motion.q);
    }
    if (joint.driven_rate) motion.u[0] = *joint.driven_rate;
    motions.push_back(motion);
  }
  return motions;
}

BodyMotion placed_child(const Joint& joint, const JointMotion& motion, const BodyMotion& parent) {
  BodyMotion child;
  const Quaternion relative = relative_orientation(joint, motion.q);
  child.q_wxyz = normalised(product(parent.q_wxyz, relative));
  child.w_rad_per_s = rotate_back(relative, parent.w_rad_per_s) + relative_body_rate(joint, motion);

  const auto [offset, rate] = slide_of(joint, motion);
  const Vector anchor_parent = wide(joint.anchors_body_m[0]), anchor_child = wide(joint.anchors_body_m[1]);
  const bool slides = joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical;
  const Vector axis = slides ? axis_of(joint) : Vector{};
  // From the child's anchor back to its centre of mass, and the slide, in the child's axes.
  const Vector slide = offset * axis;
  child.p_m = parent.p_m + rotate(parent.q_wxyz, anchor_parent) + rotate(child.q_wxyz, slide - anchor_child);
  child.v_m_per_s = parent.v_m_per_s + rotate(parent.q_wxyz, cross(parent.w_rad_per_s, anchor_parent)) +
                    rotate(child.q_wxyz, rate * axis + cross(child.w_rad_per_s, slide - anchor_child));
  return child;
}

JointMotion joint_motion(const Joint& joint, const BodyMotion& parent, const BodyMotion& child,
                         const JointMotion& near) {
  const Quaternion relative = product(conjugate(parent.q_wxyz), child.q_wxyz);
  const Quaternion turned = product(conjugate(frame_of(joint)), relative);
  const Vector w_rel = child.w_rad_per_s - rotate_back(relative, parent.w_rad_per_s);
  JointMotion out;
  if (joint.kind == JointKind::hinge || joint.kind == JointKind::cylindrical) {
    out.q[0] = angle_about(axis_of(joint), turned, near.q[0]);
    out.u[0] = dot(axis_of(joint), w_rel);
  }
  if (joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical) {
    // Anchor to anchor in the child's axes, d = R_child^T (x_child - x_parent): d' = R_child^T (v - v) - w_child x d.
    const Vector a = wide(joint.anchors_body_m[0]), b = wide(joint.anchors_body_m[1]);
    const Vector x = child.p_m + rotate(child.q_wxyz, b) - parent.p_m - rotate(parent.q_wxyz, a);
    const Vector v = child.v_m_per_s + rotate(child.q_wxyz, cross(child.w_rad_per_s, b)) - parent.v_m_per_s -
                     rotate(parent.q_wxyz, cross(parent.w_rad_per_s, a));
    const Vector d = rotate_back(child.q_wxyz, x);
    const std::size_t at = joint.kind == JointKind::slider ? 0 : 1;
    out.q[at] = dot(axis_of(joint), d);
    out.u[at] = dot(axis_of(joint), rotate_back(child.q_wxyz, v) - cross(child.w_rad_per_s, d));
  }
  if (joint.kind == JointKind::universal) universal_motion(joint, relative, w_rel, near, out);
  if (joint.kind == JointKind::ball) {
    out.q = normalised(turned);
    Real product_with_near = 0;
    for (std::size_t i = 0; i < 4; ++i) product_with_near += out.q[i] * near.q[i];
    if (product_with_near < 0)
      for (Real& x : out.q) x = -x;
    out.u = w_rel;
  }
  return out;
}

MechanismStart mechanism_start(const Scene& scene) {
  MechanismStart start{given_motions(scene), given_joint_motions(scene)};
  const BodyMotion world = world_motion();
  for (const int j : joints_from_root(scene)) {
    const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
    start.bodies[static_cast<std::size_t>(joint.child)] =
        placed_child(joint, start.joints[static_cast<std::size_t>(j)], motion_of(start.bodies, joint.parent, world));
  }
  project_start(scene, start);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    if (!joint.closes_loop) continue;
    start.joints[j] = joint_motion(joint, motion_of(start.bodies, joint.parent, world),
                                   motion_of(start.bodies, joint.child, world), start.joints[j]);
  }
  return start;
}

}  // namespace atwood
