// A body on a hinge or slider whose coordinate obeys a linear equation with constant coefficients,
//   J q'' + c q' + k q = k rest + constant force + sum of M cos(w t + phi)
// J: the mass (slider) or the moment of inertia about the axis (hinge; gravity then has no moment about it). With
//   2 gamma = c / J,  W^2 = k / J  and  C, s: solutions of x'' + 2 gamma x' + W^2 x = 0 with (1, 0) and (0, 1) at t = 0
// the free motion is x0 C + v0 s, a constant acceleration a adds a P, P = int_0^t s, and a drive its particular
// solution. Landau and Lifshitz, Mechanics, sections 21, 22, 25, 26.
#include "closed_form/entire.hpp"
#include "closed_form/mechanism.hpp"

namespace atwood::closed_form {

namespace {

// x'' + 2 gamma x' + stiffness x = 0
template <class S> struct Fundamental { S c{}, s{}, p{}; };  // C, s, P
template <class S> Fundamental<S> fundamental(S gamma, S stiffness, S t) {
  Fundamental<S> made;
  if (stiffness == 0) {
    made.c = 1;
    const S fall = 2 * gamma * t;
    if (magnitude(fall) > S(0.5)) {
      made.s = -expm1(-fall) / (2 * gamma);
      made.p = (t - made.s) / (2 * gamma);
      return made;
    }
    S term = t;  // s = t sum (-fall)^n / (n + 1)!, P = t^2 sum (-fall)^n / (n + 2)!
    for (int n = 0; magnitude(term) > unit_round_off<S>() * t / 8; ++n) {
      made.s += term / (n + 1);
      made.p += term * t / ((n + 1) * (n + 2));
      term *= -fall / (n + 1);
    }
    return made;
  }
  const S frequency = sqrt(stiffness), y = (gamma - frequency) * (gamma + frequency) * t * t;
  if (y > 1) {  // overdamped; the slow rate without cancellation
    const S beta = sqrt(y) / t, slow = stiffness / (gamma + beta), fast = gamma + beta;
    const S late = exp(-slow * t), soon = exp(-fast * t);
    made.s = (late - soon) / (2 * beta);
    made.c = (fast * late - slow * soon) / (2 * beta);
    made.p = (-expm1(-slow * t) / slow + expm1(-fast * t) / fast) / (2 * beta);
    return made;
  }
  const S decay = exp(-gamma * t), root = decay * cosh_root(y);
  made.s = decay * t * sinhc_root(y);
  made.c = root + gamma * made.s;
  made.p = (1 - made.c) / stiffness;  // int (s'' + 2 gamma s' + W^2 s) = 0 and s' = C - 2 gamma s
  return made;
}

template <class S> struct LinearJoint {
  S q0{}, u0{}, gamma{}, stiffness{}, push{};  // per moment of inertia
  struct Drive {
    S push{}, w{}, phase{};
  };
  std::vector<Drive> drives;

  // Re[push exp i(w t + phase) / (stiffness - w^2 + 2 i gamma w)] and its derivative.
  std::array<S, 2> particular(const Drive& drive, S t) const {
    const S frequency = sqrt(stiffness), re = (frequency - drive.w) * (frequency + drive.w), im = 2 * gamma * drive.w;
    const S square = re * re + im * im, c = cos(drive.w * t + drive.phase), s = sin(drive.w * t + drive.phase);
    if (square == 0) return {drive.push * t * s / (2 * drive.w), drive.push * (s + drive.w * t * c) / (2 * drive.w)};
    return {drive.push * (re * c + im * s) / square, drive.push * drive.w * (im * c - re * s) / square};
  }

  JointState<S> at(S t) const {
    S x = q0, v = u0, xp = 0, vp = 0, force = push;
    for (const Drive& drive : drives) {
      const std::array<S, 2> first = particular(drive, S(0)), now = particular(drive, t);
      x -= first[0];
      v -= first[1];
      xp += now[0];
      vp += now[1];
      force += drive.push * cos(drive.w * t + drive.phase);
    }
    const Fundamental<S> f = fundamental(gamma, stiffness, t);
    JointState<S> made;
    made.q[0] = x * f.c + v * f.s + push * f.p + xp;
    made.u[0] = v * (f.c - 2 * gamma * f.s) + (push - stiffness * x) * f.s + vp;
    made.du[0] = force - stiffness * made.q[0] - 2 * gamma * made.u[0];
    return made;
  }
};

}  // namespace

template <class S> std::string single_joint(const Scene& scene, std::size_t index, S& inertia, S& gravity) {
  const Joint& joint = scene.joints[index];
  const std::string name = "the joint `" + joint.name + "`";
  if (!is_grounded(scene, joint)) return name + " does not join its body to the world";
  const Body& body = scene.bodies[static_cast<std::size_t>(joint.child)];
  std::vector<JointState<S>> start;
  for (const Joint& each : scene.joints) start.push_back(initial_joint<S>(each));
  const Quat<S> q = place_bodies(scene, start)[static_cast<std::size_t>(joint.child)].pose.q_WB;
  const Vec<S> axis = unit<S>(joint.axis_body), n = rotate(q, axis), g = vec<S>(scene.gravity_m_per_s2);
  if (joint.kind == JointKind::slider) {
    inertia = body.mass_kg;
    gravity = inertia * dot(n, g);
    return "";
  }
  const Vec<S> d = cross(axis, vec<S>(joint.anchors_body_m[1])), d_W = rotate(q, d);
  inertia = S(body.mass_kg) * dot(d, d);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) inertia += axis[i] * S(body.inertia_kg_m2[3 * i + j]) * axis[j];
  gravity = 0;
  // d_W = -n x (centre - anchor): the moment is a sinusoid of the angle, with this amplitude.
  const Vec<S> g_across = g - dot(g, n) * n;
  if (norm(d_W) * norm(g_across) > 4 * unit_round_off<S>() * norm(g) * norm(vec<S>(joint.anchors_body_m[1])))
    return "gravity has a moment about the hinge `" + joint.name + "`";
  return "";
}

template std::string single_joint(const Scene&, std::size_t, Narrow&, Narrow&);
template std::string single_joint(const Scene&, std::size_t, Wide&, Wide&);

namespace {

template <class S> std::string build(const Scene& scene, std::size_t index, LinearJoint<S>& made) {
  S inertia, gravity;
  if (const std::string why = single_joint(scene, index, inertia, gravity); !why.empty()) return why;
  const JointState<S> start = initial_joint<S>(scene.joints[index]);
  made.q0 = start.q[0];
  made.u0 = start.u[0];
  made.push = gravity / inertia;
  for (const JointForce& force : scene.joint_forces) {
    if (const auto* spring = std::get_if<JointSpring>(&force)) {
      if (spring->joint != static_cast<int>(index)) continue;
      made.stiffness += S(spring->stiffness) / inertia;
      made.gamma += S(spring->damping) / inertia / 2;
      made.push += S(spring->stiffness) * S(spring->rest) / inertia;
      continue;
    }
    const auto& motor = std::get<JointTorque>(force);
    if (motor.joint != static_cast<int>(index)) continue;
    const S w = motor.angular_frequency_rad_per_s;
    if (w == 0) made.push += S(motor.torque) * cos(S(motor.phase_rad)) / inertia;
    else made.drives.push_back({S(motor.torque) / inertia, w, S(motor.phase_rad)});
  }
  // Beside resonance the driven and the free part are large and cancel; at it exactly the formula is another one.
  for (const auto& drive : made.drives) {
    const S re = made.stiffness - drive.w * drive.w, im = 2 * made.gamma * drive.w, size = sqrt(re * re + im * im);
    const bool at = (sqrt(made.stiffness) - drive.w) == 0 && im == 0;
    if (!at && size < S(0x1p-20) * larger(made.stiffness, drive.w * drive.w))
      return "the joint `" + scene.joints[index].name + "` is driven within 2^-20 of its resonance, but not at it";
  }
  return "";
}

template <class S> Motion<S> solve_linear_joint(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> refused;
  refused.refusal = not_a_tree(scene);
  if (refused.refusal.empty() && scene.joints.empty()) refused.refusal = "expected a hinge or slider; found none";
  std::vector<LinearJoint<S>> all(scene.joints.size());
  for (std::size_t j = 0; j < all.size() && refused.refusal.empty(); ++j) refused.refusal = build(scene, j, all[j]);
  if (!refused.refusal.empty()) return refused;
  return move_mechanism<S>(scenario, t_s, [&](S t) {
    std::vector<JointState<S>> joints;
    for (const LinearJoint<S>& each : all) joints.push_back(each.at(t));
    return joints;
  });
}

}  // namespace

Solution linear_joint() {
  return {"linear-joint",
          "a hinge or slider with a linear spring, damper and motor, Landau and Lifshitz, Mechanics, sections 21-26",
          feature::uniform_gravity | feature::spin | feature::hinge | feature::slider | feature::joint_stiffness |
              feature::joint_damping | feature::joint_torque | feature::oscillating_torque,
          solve_linear_joint<Narrow>, solve_linear_joint<Wide>};
}

}  // namespace atwood::closed_form
