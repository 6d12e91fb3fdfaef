// The slider-crank whose crank turns at a constant rate: a driven hinge to the world, a rod, and a piston on a straight
// slide. In the plane of the motion, with d along the slide, e = n x d, the crank's pin at A and the rod's other end at
// B = A + L (cos phi d + sin phi e), which stays at the height h along e:
//   sin phi = (h - A.e) / L,   x = A.d + L cos phi
// and derivatives; forces and the motor's torque from the Newton-Euler equations. J. J. Uicker, G. R. Pennock and
// J. E. Shigley, Theory of Machines and Mechanisms, 4th ed. (2011), sections 2.9 and 14.
#include "closed_form/mechanism.hpp"

namespace atwood::closed_form {

namespace {

template <class S> S arcsine(S x) { return atan2(x, sqrt((1 - x) * (1 + x))); }

struct Roles {
  std::size_t motor = 0, crank_pin = 0, piston_pin = 0, slide = 0;  // joints
  int crank = -1, rod = -1, piston = -1;                            // bodies
};

// The joint other than `not_this` between `body` and some body, and that body.
bool next_hinge(const Scene& scene, int body, std::size_t not_this, std::size_t& joint, int& other) {
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& each = scene.joints[j];
    if (j == not_this || each.kind != JointKind::hinge) continue;
    const int parent = moving_body(scene, each.parent);
    if (each.child != body && parent != body) continue;
    joint = j;
    other = each.child == body ? parent : each.child;
    return other >= 0;
  }
  return false;
}

std::string find_roles(const Scene& scene, Roles& roles) {
  const std::string expected = "expected a crank on a driven hinge, a rod and a piston, joined by hinges, and a slider";
  if (scene.joints.size() != 4) return expected;
  int motors = 0, slides = 0, loops = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    const Joint& joint = scene.joints[j];
    loops += joint.closes_loop ? 1 : 0;
    if (joint.driven_rate) roles.motor = j, ++motors;
    if (joint.kind == JointKind::slider) roles.slide = j, ++slides;
  }
  if (motors != 1 || slides != 1 || loops != 1 || roles.motor == roles.slide) return expected;
  if (!is_grounded(scene, scene.joints[roles.motor]) || !is_grounded(scene, scene.joints[roles.slide])) return expected;
  roles.crank = scene.joints[roles.motor].child;
  int end = -1;
  if (!next_hinge(scene, roles.crank, roles.motor, roles.crank_pin, roles.rod) ||
      !next_hinge(scene, roles.rod, roles.crank_pin, roles.piston_pin, end))
    return expected;
  roles.piston = scene.joints[roles.slide].child;
  return end == roles.piston && roles.piston != roles.crank ? "" : expected;
}

template <class S> struct SliderCrank {
  Roles roles;
  std::vector<JointState<S>> start;
  std::vector<int> child_turns, parent_turns;  // of each joint: 0 the world or piston, 1 the crank, 2 the rod
  std::vector<S> sign;
  S W{}, A_d{}, A_e{}, L{}, h{}, side = 1;
  S phi0{}, x0{};

  // phi, x and their first two derivatives. cos phi = 0: the rod does not pass that place.
  struct State {
    std::array<S, 3> phi{}, x{};
    bool reaches = true;
  };
  State plane(S t) const {
    const S c = cos(W * t), s = sin(W * t);
    const S d = A_d * c - A_e * s, e = A_d * s + A_e * c;  // A turned; its rate is W (-e, d)
    State made;
    const S sine = (h - e) / L;
    made.reaches = magnitude(sine) < 1;
    if (!made.reaches) return made;
    const S cosine = side * sqrt((1 - sine) * (1 + sine));
    made.phi[0] = side > 0 ? arcsine(sine) : pi<S>() - arcsine(sine);
    made.phi[1] = -W * d / (L * cosine);
    made.phi[2] = (W * W * e / L + sine * made.phi[1] * made.phi[1]) / cosine;
    made.x[0] = d + L * cosine;
    made.x[1] = -W * e - L * sine * made.phi[1];
    made.x[2] = -W * W * d - L * (cosine * made.phi[1] * made.phi[1] + sine * made.phi[2]);
    return made;
  }
  std::vector<JointState<S>> at(S t) const {
    const State now = plane(t);
    const std::array<std::array<S, 3>, 3> turns{
        {{0, 0, 0}, {W * t, W, 0}, {now.phi[0] - phi0, now.phi[1], now.phi[2]}}};
    std::vector<JointState<S>> made(start.size());
    for (std::size_t j = 0; j < made.size(); ++j) {
      std::array<S, 3> change{now.x[0] - x0, now.x[1], now.x[2]};
      if (j != roles.slide)
        for (std::size_t k = 0; k < 3; ++k)
          change[k] = sign[j] * (turns[static_cast<std::size_t>(child_turns[j])][k] -
                                 turns[static_cast<std::size_t>(parent_turns[j])][k]);
      made[j].q[0] = start[j].q[0] + change[0];
      made[j].u[0] = change[1];
      made[j].du[0] = change[2];
    }
    return made;
  }
};

template <class S> std::string build(const Scene& scene, SliderCrank<S>& made) {
  if (std::string why = find_roles(scene, made.roles); !why.empty()) return why;
  const Roles& roles = made.roles;
  if (std::string why = start_joints(scene, made.start); !why.empty()) return why;
  const std::vector<BodyKinematics<S>> bodies = place_bodies(scene, made.start);
  const auto orientation = [&](int body) { return bodies[static_cast<std::size_t>(body)].pose.q_WB; };
  const Joint &motor = scene.joints[roles.motor], &slide = scene.joints[roles.slide];
  const Vec<S> n = rotate(orientation(roles.crank), unit<S>(motor.axis_body)),
               d = rotate(orientation(roles.piston), unit<S>(slide.axis_body)), e = cross(n, d);
  if (magnitude(dot(n, d)) > 256 * unit_round_off<S>()) return "the slide does not lie in the plane of the crank";
  const auto turns = [&](int body) { return body == roles.crank ? 1 : body == roles.rod ? 2 : 0; };
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    made.sign.push_back(j == roles.slide ? S(1) : sign_along(joint, bodies, n));
    if (made.sign.back() == 0) return "the axis of the hinge `" + joint.name + "` is not parallel to that of the crank";
    made.child_turns.push_back(turns(joint.child));
    made.parent_turns.push_back(turns(joint.parent));
  }
  // A joint that closes the loop has its two anchors at one place to the accuracy of the start alone.
  const Vec<S> O = anchor_at(motor, 1, bodies), A = anchor_at(scene.joints[roles.crank_pin], 1, bodies),
               B = anchor_at(scene.joints[roles.piston_pin], 1, bodies);
  const Vec<S> a = A - O, b = B - A;
  made.W = made.start[roles.motor].u[0] * made.sign[roles.motor];
  made.A_d = dot(a, d);
  made.A_e = dot(a, e);
  made.L = sqrt(dot(b, d) * dot(b, d) + dot(b, e) * dot(b, e));
  made.h = dot(a + b, e);
  made.side = dot(b, d) < 0 ? -1 : 1;
  if (!(made.L > 0)) return "the rod has no length";
  const S least = magnitude(made.h) + norm(Vec<S>{made.A_d, made.A_e, 0});
  if (!(least < made.L * (1 - S(1e-6)))) return "the rod is too short for the crank to turn";
  const auto now = made.plane(S(0));
  made.phi0 = now.phi[0];
  made.x0 = now.x[0];
  return "";
}

template <class S> Motion<S> solve_slider_crank(const Scenario& scenario, const std::vector<S>& t_s) {
  Motion<S> refused;
  SliderCrank<S> path;
  refused.refusal = not_a_tree(scenario.scene);
  if (refused.refusal.empty()) refused.refusal = build(scenario.scene, path);
  if (!refused.refusal.empty()) return refused;
  return move_mechanism<S>(scenario, t_s, [&](S t) { return path.at(t); });
}

}  // namespace

Solution slider_crank() {
  return {
      "slider-crank",
      "slider-crank at a constant rate of the crank, Uicker, Pennock and Shigley, Theory of Machines and Mechanisms",
      feature::uniform_gravity | feature::spin | feature::hinge | feature::slider | feature::loop |
          feature::driven_joint | feature::joint_stiffness | feature::joint_damping | feature::joint_torque |
          feature::oscillating_torque,
      solve_slider_crank<Narrow>, solve_slider_crank<Wide>};
}

}  // namespace atwood::closed_form
