// A body that slides on a rod, which turns at a constant rate W about a fixed axis n (a driven hinge). Along the rod,
// with d its direction and r the body's centre from a point of the axis,
//   x'' = W^2 (d - (d.n) n) . r + g . d(t):   x'' = K^2 x + constant + P cos W t + Q sin W t,   K^2 = W^2 (1 - (d.n)^2)
// E. T. Whittaker, Analytical Dynamics, 4th ed. (1937), section 34.
#include "closed_form/mechanism.hpp"

namespace atwood::closed_form {

namespace {

template <class S> struct SlidingBody {
  S q0{}, u0{}, turn0{}, W{};
  S K{}, constant{}, P{}, Q{};

  std::array<S, 3> particular(S t) const {  // and its two derivatives
    const S c = cos(W * t), s = sin(W * t), size = K * K + W * W;
    return {-(P * c + Q * s) / size, W * (P * s - Q * c) / size, W * W * (P * c + Q * s) / size};
  }
  JointState<S> at(S t) const {
    const std::array<S, 3> first = particular(S(0)), now = particular(t);
    const S x = -first[0], v = u0 - first[1];
    S grown = t, raised = t * t / 2;  // sinh(K t) / K and (cosh(K t) - 1) / K^2
    if (K != 0) {
      const S half = sinh(K * t / 2);
      grown = sinh(K * t) / K;
      raised = 2 * half * half / (K * K);
    }
    JointState<S> made;
    made.q[0] = q0 + x * cosh(K * t) + v * grown + constant * raised + now[0];
    made.u[0] = x * K * K * grown + v * cosh(K * t) + constant * grown + now[1];
    made.du[0] = K * K * (x * cosh(K * t) + v * grown) + constant * cosh(K * t) + now[2];
    return made;
  }
};

template <class S>
std::string build(const Scene& scene, std::size_t& hinge, std::size_t& slider, SlidingBody<S>& made) {
  if (scene.joints.size() != 2)
    return "expected a hinge and a slider; found " + std::to_string(scene.joints.size()) + " joints";
  hinge = scene.joints[0].kind == JointKind::hinge ? 0 : 1;
  slider = 1 - hinge;
  const Joint &turns = scene.joints[hinge], &slides = scene.joints[slider];
  if (turns.kind != JointKind::hinge || slides.kind != JointKind::slider) return "expected a hinge and a slider";
  if (!is_grounded(scene, turns) || !turns.driven_rate || slides.driven_rate || slides.parent != turns.child)
    return "expected a slider on a rod whose hinge to the world is driven";
  std::vector<JointState<S>> start;
  for (const Joint& each : scene.joints) start.push_back(initial_joint<S>(each));
  const std::vector<BodyKinematics<S>> bodies = place_bodies(scene, start);
  const Pose<S>&rod = bodies[static_cast<std::size_t>(turns.child)].pose,
        &bead = bodies[static_cast<std::size_t>(slides.child)].pose;
  const Vec<S> n = rotate(rod.q_WB, unit<S>(turns.axis_body)), d = rotate(bead.q_WB, unit<S>(slides.axis_body)),
               g = vec<S>(scene.gravity_m_per_s2),
               r = bead.p_WB - rod.p_WB - rotate(rod.q_WB, vec<S>(turns.anchors_body_m[1]));
  const S W = made.W = start[hinge].u[0], dn = dot(d, n);
  if (W == 0) return "the hinge `" + turns.name + "` is driven at a rate of 0";
  const Vec<S> across = cross(n, d);  // of length sqrt(1 - (d.n)^2)
  made.K = magnitude(W) * norm(across);
  made.constant = W * W * (dot(d, r) - dn * dot(r, n)) + dot(g, n) * dn;
  made.P = dot(g, d) - dot(g, n) * dn;
  made.Q = dot(g, across);
  made.q0 = start[slider].q[0];
  made.u0 = start[slider].u[0];
  made.turn0 = start[hinge].q[0];
  return "";
}

template <class S> Motion<S> solve_turning_rod(const Scenario& scenario, const std::vector<S>& t_s) {
  Motion<S> refused;
  SlidingBody<S> path;
  std::size_t hinge = 0, slider = 0;
  refused.refusal = not_a_tree(scenario.scene);
  if (refused.refusal.empty()) refused.refusal = build(scenario.scene, hinge, slider, path);
  if (!refused.refusal.empty()) return refused;
  return move_mechanism<S>(scenario, t_s, [&](S t) {
    std::vector<JointState<S>> joints(2);
    joints[slider] = path.at(t);
    joints[hinge].q[0] = path.turn0 + path.W * t;
    joints[hinge].u[0] = path.W;
    return joints;
  });
}

}  // namespace

Solution turning_rod() {
  return {"turning-rod", "a slider on a rod turned at a constant rate, Whittaker, Analytical Dynamics, section 34",
          feature::uniform_gravity | feature::spin | feature::hinge | feature::slider | feature::driven_joint,
          solve_turning_rod<Narrow>, solve_turning_rod<Wide>};
}

}  // namespace atwood::closed_form
