// The pendulum: a body on a hinge whose axis is fixed in space, under uniform gravity. With J the moment of inertia
// about the axis, d the distance of the centre of mass from it, and the part g' of gravity that is orthogonal to it,
//   theta'' = -w^2 sin theta,   w^2 = m g' d / J,   theta from the hanging position,
//   k^2 = sin^2(theta / 2) + (theta' / 2w)^2  is constant:
//   k < 1  sin(theta / 2) = k sn(u, k),  theta' = 2 w k cn(u, k),    u = w t + u0     (libration)
//   k > 1  theta / 2 = +-am(u, 1/k),     theta' = +-2 w k dn(u, 1/k), u = w k t + u0  (rotation)
//   k = 1  sin(theta / 2) = tanh u,      theta' = 2 w / cosh u                         (separatrix)
// E. T. Whittaker, Analytical Dynamics, 4th ed. (1937), section 44; moments of the hinge from Euler's equations, so
// that the axis need not be a principal one.
#include "closed_form/pendulum.hpp"

#include "closed_form/elliptic.hpp"
#include "closed_form/mechanism.hpp"

namespace atwood::closed_form {

template <class S> JointState<S> Pendulum<S>::at(S t) const {
  JointState<S> made;
  S theta = theta0, rate = 0;
  if (k != 0) {
    const Jacobi<S> now = jacobi(frequency * (turns() ? k : S(1)) * t + u0, kc);
    const S side = now.halves != 2 * floor(now.halves / 2) ? -sign : sign;
    if (turns()) {
      theta = sign * 2 * (atan2(now.sn, now.cn) + now.halves * pi<S>());
      rate = sign * 2 * frequency * k * now.dn;
    } else {
      theta = 2 * atan2(side * k * now.sn, now.dn);
      rate = side * 2 * frequency * k * now.cn;
    }
  }
  made.q[0] = q0 + (theta - theta0);
  made.u[0] = rate;
  made.du[0] = -frequency * frequency * sin(theta);
  return made;
}

template <class S>
Pendulum<S> swing(S inertia, const Vec<S>& first_moment_W, const Vec<S>& n, const Vec<S>& g, S q0, S rate) {
  Pendulum<S> made;
  const S down = dot(first_moment_W, g), aside = dot(n, cross(g, first_moment_W));
  made.frequency = sqrt(norm(first_moment_W) * norm(g) / inertia);
  made.q0 = q0;
  made.theta0 = atan2(aside, down);
  const S s = sin(made.theta0 / 2), c = cos(made.theta0 / 2), r = rate / (2 * made.frequency);
  made.k = sqrt(s * s + r * r);
  if (made.k == 0) return made;
  made.sign = r < 0 ? -1 : 1;                              // cn >= 0 at u0
  const S left = (c - magnitude(r)) * (c + magnitude(r));  // 1 - k^2; c >= 0
  S sn = made.sign * s, cn = c, dn = c;
  if (left >= 0) {
    if (left == 0) made.k = 1;
    made.kc = sqrt(left);
    sn /= made.k;
    cn = magnitude(r) / made.k;
  } else {
    made.k = sqrt(1 - left);
    made.kc = sqrt(-left) / made.k;
    dn = magnitude(r) / made.k;
  }
  made.u0 = sn * carlson_rf(cn * cn, dn * dn, S(1));
  return made;
}

template struct Pendulum<Narrow>;
template struct Pendulum<Wide>;
template Pendulum<Narrow> swing(Narrow, const Vec<Narrow>&, const Vec<Narrow>&, const Vec<Narrow>&, Narrow, Narrow);
template Pendulum<Wide> swing(Wide, const Vec<Wide>&, const Vec<Wide>&, const Vec<Wide>&, Wide, Wide);

namespace {

// Moment of inertia about the axis n (in body axes) through the anchor.
template <class S> S moment_about(const Body& body, const Vec<S>& n, const Vec<S>& anchor) {
  S sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) sum += n[i] * S(body.inertia_kg_m2[3 * i + j]) * n[j];
  const Vec<S> arm = cross(n, anchor);
  return sum + S(body.mass_kg) * dot(arm, arm);
}

template <class S> std::string build(const Scene& scene, std::size_t index, Pendulum<S>& made) {
  const Joint& joint = scene.joints[index];
  if (!is_grounded(scene, joint)) return "the hinge `" + joint.name + "` does not join its body to the world";
  const Body& body = scene.bodies[static_cast<std::size_t>(joint.child)];
  std::vector<JointState<S>> start;
  for (const Joint& each : scene.joints) start.push_back(initial_joint<S>(each));
  const Quat<S> q = place_bodies(scene, start)[static_cast<std::size_t>(joint.child)].pose.q_WB;
  const Vec<S> axis = unit<S>(joint.axis_body), anchor = vec<S>(joint.anchors_body_m[1]), n = rotate(q, axis),
               g = vec<S>(scene.gravity_m_per_s2);
  // Of the centre from the anchor and of gravity, the parts across the axis, as (down, aside) = (d . g, n . (g x d)).
  const Vec<S> d = rotate(q, S(-1) * anchor), d_across = d - dot(d, n) * n, g_across = g - dot(g, n) * n;
  const S least = 64 * unit_round_off<double>() * norm(d) * norm(g);
  const S mass = body.mass_kg;
  if (!(norm(d_across) * norm(g_across) > least)) return "gravity has no moment about the hinge `" + joint.name + "`";
  made = swing<S>(moment_about(body, axis, anchor), mass * d_across, n, g_across, start[index].q[0], start[index].u[0]);
  return "";
}

template <class S> Motion<S> solve_pendulum(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> refused;
  refused.refusal = not_a_tree(scene);
  if (refused.refusal.empty() && scene.joints.empty()) refused.refusal = "expected a hinge; found none";
  std::vector<Pendulum<S>> all(scene.joints.size());
  for (std::size_t j = 0; j < all.size() && refused.refusal.empty(); ++j) refused.refusal = build(scene, j, all[j]);
  if (!refused.refusal.empty()) return refused;
  return move_mechanism<S>(scenario, t_s, [&](S t) {
    std::vector<JointState<S>> joints;
    for (const Pendulum<S>& each : all) joints.push_back(each.at(t));
    return joints;
  });
}

}  // namespace

Solution pendulum() {
  return {"pendulum", "physical pendulum, Whittaker, Analytical Dynamics, section 44 (Jacobi's elliptic functions)",
          feature::uniform_gravity | feature::spin | feature::hinge, solve_pendulum<Narrow>, solve_pendulum<Wide>};
}

}  // namespace atwood::closed_form
