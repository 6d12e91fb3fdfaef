// Two shafts on fixed bearings whose axes meet, joined by a universal joint there; the first turns at a constant rate
// W. With n1, n2 the bearings' axes, e along n1 x n2, f1 = n1 x e, f2 = n2 x e and the first shaft's pin a1 = c e + s
// f1 (c, s: cosine and sine of its angle), the second shaft's pin is orthogonal to a1 and n2. With b the angle of n2 x
// pin,
//   tan b = cos(beta) tan a
//   b'  = W cos(beta) / D,   D = 1 - sin^2(beta) s^2
//   b'' = 2 W^2 cos(beta) sin^2(beta) s c / D^2
// (R. Hooke, Helioscopes, 1676; J. J. Uicker, G. R. Pennock and J. E. Shigley, Theory of Machines and Mechanisms, 4th
// ed. (2011), section 12.7). The joint's rates are the parts of the relative angular velocity along its two pins;
// reactions and the motor's torque follow from the Newton-Euler equations.
#include "closed_form/mechanism.hpp"

namespace atwood::closed_form {

namespace {

struct ShaftRoles {
  std::size_t motor = 0, bearing = 0, cross = 0;  // joints
};

std::string find_shaft_roles(const Scene& scene, ShaftRoles& roles) {
  const std::string expected =
      "expected two shafts on hinges to the world, one of them driven, and a universal joint between them";
  if (scene.joints.size() != 3) return expected;
  int motors = 0, bearings = 0, crosses = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    const Joint& joint = scene.joints[j];
    if (joint.kind == JointKind::universal) roles.cross = j, ++crosses;
    else if (joint.kind == JointKind::hinge && is_grounded(scene, joint))
      (joint.driven_rate ? roles.motor : roles.bearing) = j, ++(joint.driven_rate ? motors : bearings);
  }
  if (motors != 1 || bearings != 1 || crosses != 1) return expected;
  const Joint& cross = scene.joints[roles.cross];
  const int first = scene.joints[roles.motor].child, second = scene.joints[roles.bearing].child;
  const bool joins =
      (cross.parent == first && cross.child == second) || (cross.parent == second && cross.child == first);
  return joins ? "" : expected;
}

// The angle from `from` to `to`, both unit vectors across the unit vector n.
template <class S> S angle_about(const Vec<S>& n, const Vec<S>& from, const Vec<S>& to) {
  return atan2(dot(n, cross(from, to)), dot(from, to));
}

template <class S> struct Shafts {
  ShaftRoles roles;
  std::vector<JointState<S>> start;
  bool parent_drives = true;          // the universal joint's parent is the driven shaft
  Vec<S> n1{}, n2{}, pin1{}, pin2{};  // world axes at the start; pins of the driven and of the other shaft
  S W{}, cosine{}, sine2{}, a0{};     // of the angle between the axes; the driven pin's angle from e at the start

  std::array<S, 3> driven_by(S t) const {  // b - b(0), b', b''
    const auto lead = [&](S angle) {       // b -+ angle for cos(beta) >< 0, within a quarter turn
      const S c = cos(angle), s = sin(angle);
      return cosine > 0 ? atan2((cosine - 1) * s * c, c * c + cosine * s * s)
                        : atan2((cosine + 1) * s * c, c * c - cosine * s * s);
    };
    const S a = a0 + W * t, c = cos(a), s = sin(a), D = 1 - sine2 * s * s;
    return {(cosine > 0 ? W * t : -W * t) + lead(a) - lead(a0), W * cosine / D,
            2 * W * W * cosine * sine2 * s * c / (D * D)};
  }
  std::vector<JointState<S>> at(S t) const {
    const std::array<S, 3> b = driven_by(t);
    std::vector<JointState<S>> made(3);
    JointState<S>&motor = made[roles.motor], &bearing = made[roles.bearing], &joint = made[roles.cross];
    motor.q[0] = start[roles.motor].q[0] + W * t;
    motor.u[0] = W;
    bearing.q[0] = start[roles.bearing].q[0] + b[0];
    bearing.u[0] = b[1];
    bearing.du[0] = b[2];
    const Vec<S> turned1 = rotate(turn(n1, W * t), pin1), turned2 = rotate(turn(n2, b[0]), pin2);
    const Vec<S> w1 = W * n1, w2 = b[1] * n2, alpha2 = b[2] * n2;
    const Vec<S>&first = parent_drives ? turned1 : turned2, &second = parent_drives ? turned2 : turned1;
    const Vec<S>&w_parent = parent_drives ? w1 : w2, &w_child = parent_drives ? w2 : w1;
    const Vec<S> w = w_child - w_parent, alpha = parent_drives ? alpha2 : S(-1) * alpha2;
    joint.u = {dot(w, first), dot(w, second), 0};
    joint.du = {dot(alpha, first) + dot(w, cross(w_parent, first)), dot(alpha, second) + dot(w, cross(w_child, second)),
                0};
    // exp(a1 q0) takes F a2 to where the second pin is seen from the parent, and exp(-a2 q1) F^T a1 is the first seen
    // from the child: each angle changes by that of the other's pin, in axes that turn with the shaft.
    const S back1 = -W * t, back2 = -b[0];
    const Vec<S> second_in_parent = rotate(turn(parent_drives ? n1 : n2, parent_drives ? back1 : back2), second);
    const Vec<S> first_in_child = rotate(turn(parent_drives ? n2 : n1, parent_drives ? back2 : back1), first);
    const Vec<S>&first0 = parent_drives ? pin1 : pin2, &second0 = parent_drives ? pin2 : pin1;
    joint.q[0] = start[roles.cross].q[0] + angle_about(first0, second0, second_in_parent);
    joint.q[1] = start[roles.cross].q[1] - angle_about(second0, first0, first_in_child);
    return made;
  }
};

template <class S> std::string build(const Scene& scene, Shafts<S>& made) {
  if (std::string why = find_shaft_roles(scene, made.roles); !why.empty()) return why;
  if (std::string why = start_joints(scene, made.start); !why.empty()) return why;
  const std::vector<BodyKinematics<S>> bodies = place_bodies(scene, made.start);
  const Joint &motor = scene.joints[made.roles.motor], &bearing = scene.joints[made.roles.bearing],
              &joint = scene.joints[made.roles.cross];
  const auto turned = [&](int body, const Real3& axis) {
    return rotate(bodies[static_cast<std::size_t>(body)].pose.q_WB, unit<S>(axis));
  };
  made.parent_drives = joint.parent == motor.child;
  made.n1 = turned(motor.child, motor.axis_body);
  made.n2 = turned(bearing.child, bearing.axis_body);
  const Vec<S> first = turned(joint.parent, joint.axes_body[0]), second = turned(joint.child, joint.axes_body[1]);
  made.pin1 = made.parent_drives ? first : second;
  made.pin2 = made.parent_drives ? second : first;
  made.W = made.start[made.roles.motor].u[0];
  const S rounding = 4096 * unit_round_off<S>();  // the start is projected to a little more than that of quad
  if (magnitude(dot(made.n1, made.pin1)) > rounding || magnitude(dot(made.n2, made.pin2)) > rounding)
    return "a pin of the universal joint is not orthogonal to its shaft";
  if (magnitude(dot(first, second)) > rounding) return "the pins of the universal joint are not orthogonal";
  const Vec<S> centre = anchor_at(joint, 1, bodies);
  for (const Joint* each : {&motor, &bearing}) {
    const Vec<S> arm = centre - anchor_at(*each, 1, bodies);
    if (norm(cross(arm, each == &motor ? made.n1 : made.n2)) > rounding * larger(norm(arm), norm(centre)))
      return "the universal joint is not on the axis of the hinge `" + each->name + "`";
  }
  const Vec<S> across = cross(made.n1, made.n2);
  made.cosine = dot(made.n1, made.n2);
  made.sine2 = dot(across, across);
  if (magnitude(made.cosine) < S(1e-3)) return "the shafts are orthogonal: the joint does not turn";
  const S sine = sqrt(made.sine2);
  const Vec<S> e = sine > 0 ? (1 / sine) * across : made.pin1;
  made.a0 = angle_about(made.n1, e, made.pin1);
  return "";
}

template <class S> Motion<S> solve_hooke_shaft(const Scenario& scenario, const std::vector<S>& t_s) {
  Motion<S> refused;
  Shafts<S> path;
  refused.refusal = not_a_tree(scenario.scene);
  if (refused.refusal.empty()) refused.refusal = build(scenario.scene, path);
  if (!refused.refusal.empty()) return refused;
  return move_mechanism<S>(scenario, t_s, [&](S t) { return path.at(t); });
}

}  // namespace

Solution hooke_shaft() {
  return {
      "hooke-shaft",
      "two shafts and a universal joint, the first at a constant rate, Uicker, Pennock and Shigley, Theory of Machines "
      "and Mechanisms, section 12.7",
      feature::uniform_gravity | feature::spin | feature::hinge | feature::universal_joint | feature::loop |
          feature::driven_joint | feature::joint_stiffness | feature::joint_damping | feature::joint_torque |
          feature::oscillating_torque,
      solve_hooke_shaft<Narrow>, solve_hooke_shaft<Wide>};
}

}  // namespace atwood::closed_form
