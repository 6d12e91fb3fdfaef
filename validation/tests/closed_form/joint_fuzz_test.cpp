// Random mechanisms around the guard of each closed form: it refuses, or it agrees with the certified solver in maximal
// and reduced coordinates, which shares no code with it, within both bars.
#include <catch2/catch.hpp>
#include <random>

#include "extended/extended.hpp"
#include "joint_scenes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

struct Dice {
  std::mt19937 engine;
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  int upto(int n) { return std::uniform_int_distribution<int>(0, n)(engine); }
  bool one_in(int n) { return upto(n - 1) == 0; }
  Real3 vector(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  Real3 direction() {
    if (one_in(2)) {
      Real3 axis{0, 0, 0};
      axis[static_cast<std::size_t>(upto(2))] = one_in(2) ? 1 : -1;
      return axis;
    }
    const Real3 v = vector(1);
    const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return {v[0] / length, v[1] / length, v[2] / length};
  }
  Real4 quaternion() {
    if (one_in(3)) return {1, 0, 0, 0};
    const Real3 v = direction();
    const double half = in(-1.5, 1.5), s = std::sin(half);
    return {std::cos(half), s * v[0], s * v[1], s * v[2]};
  }
  Body body(const std::string& name) {
    // Three pairs of points on orthogonal lines, skewed by a small product of inertia.
    const double a = in(0.1, 1), b = in(0.1, 1), c = in(0.1, 1), skew = one_in(2) ? 0 : in(-0.05, 0.05);
    Body made = solid(name, in(0.5, 3), {b + c, c + a, a + b}, {0, 0, 0});
    made.inertia_kg_m2[1] = made.inertia_kg_m2[3] = skew;
    return made;
  }
};

Scenario scene_of(const std::string& solution, double t_end_s, Real3 gravity, std::vector<Body> bodies,
                  std::vector<Joint> joints) {
  Scenario given = scenario(solution, t_end_s);
  given.scene.gravity_m_per_s2 = gravity;
  given.scene.bodies = std::move(bodies);
  given.scene.joints = std::move(joints);
  return given;
}

// The parent of some mechanisms is a fixed body.
void stand_on_body(Dice& dice, Scenario& given) {
  if (dice.one_in(2)) return;
  Body wall = point("wall", 0, dice.vector(1), {0, 0, 0});
  wall.fixed = true;
  wall.orientation_wxyz = dice.quaternion();
  given.scene.bodies.push_back(wall);
  for (Joint& each : given.scene.joints)
    if (each.parent < 0) each.parent = static_cast<int>(given.scene.bodies.size()) - 1;
}

Scenario random_pendulum(Dice& dice) {
  Joint pin = with_start(joint("pin", JointKind::hinge, -1, 0, dice.vector(1), dice.vector(0.7), dice.direction()),
                         dice.in(-4, 4), dice.one_in(3) ? 0 : dice.in(-8, 8));
  pin.frame_wxyz = dice.quaternion();
  Scenario given =
      scene_of("pendulum", 1, dice.one_in(2) ? Real3{0, 0, -9.81} : dice.vector(10), {dice.body("bar")}, {pin});
  stand_on_body(dice, given);
  return given;
}

Scenario random_top(Dice& dice) {
  const auto axis = static_cast<std::size_t>(dice.upto(2));
  const double across = dice.in(0.1, 0.5), along = dice.in(0.02, 2 * across);
  Real3 moments{across, across, across}, anchor{0, 0, 0};
  moments[axis] = along;
  anchor[axis] = dice.in(-0.6, 0.6);
  Joint tip = joint("tip", JointKind::ball, -1, 0, dice.vector(1), anchor);
  tip.coordinates = dice.quaternion();
  tip.frame_wxyz = dice.quaternion();
  tip.rates = dice.vector(3);
  tip.rates[axis] = dice.one_in(3) ? 0 : dice.in(-30, 30);
  Scenario given = scene_of("heavy-top", 0.5, dice.one_in(2) ? Real3{0, 0, -9.81} : dice.vector(10),
                            {solid("top", dice.in(0.5, 2), moments, {0, 0, 0})}, {tip});
  stand_on_body(dice, given);
  return given;
}

Scenario random_rod(Dice& dice) {
  Joint motor = with_start(joint("motor", JointKind::hinge, -1, 0, dice.vector(1), dice.vector(0.5), dice.direction()),
                           dice.in(-3, 3), 0);
  motor.driven_rate = motor.rates[0] = dice.in(-4, 4);
  motor.frame_wxyz = dice.quaternion();
  Joint bore = with_start(joint("bore", JointKind::slider, 0, 1, dice.vector(0.5), dice.vector(0.5), dice.direction()),
                          dice.in(-1, 1), dice.in(-1, 1));
  bore.frame_wxyz = dice.quaternion();
  Scenario given = scene_of("turning-rod", 0.75, dice.one_in(3) ? Real3{0, 0, 0} : dice.vector(9),
                            {dice.body("rod"), dice.body("bead")}, {motor, bore});
  stand_on_body(dice, given);
  return given;
}

// Bodies may be listed in any order.
Scenario random_crank(Dice& dice) {
  const double r = dice.in(0.2, 0.5), L = dice.in(0.9, 1.5), h = dice.in(-0.2, 0.2), W = dice.in(-4, 4),
               angle = dice.in(-3, 3), phi = std::asin((h - r * std::sin(angle)) / L),
               rod_rate = -W * r * std::cos(angle) / (L * std::cos(phi));
  const double flip = dice.one_in(2) ? -1 : 1;
  Joint motor = with_start(joint("motor", JointKind::hinge, -1, 2, {0, 0, 0}, {-r / 2, 0, 0}, {0, 0, 1}), angle, W);
  motor.driven_rate = W;
  Joint pin = with_start(joint("pin", JointKind::hinge, 2, 0, {r / 2, 0, 0}, {-L / 2, 0, 0.125}, {0, 0, flip}),
                         flip * (phi - angle), flip * (rod_rate - W));
  Joint rail =
      with_start(joint("rail", JointKind::slider, -1, 1, {0, h, 0}, {0, 0, 0}, {1, 0, 0}),
                 r * std::cos(angle) + L * std::cos(phi), -W * r * std::sin(angle) - L * std::sin(phi) * rod_rate);
  Joint wrist = joint("wrist", JointKind::hinge, 0, 1, {L / 2, 0, 0.125}, {0, 0, 0});
  wrist.closes_loop = true;
  wrist.coordinates[0] = -phi;
  wrist.rates[0] = -rod_rate;
  Scenario given = scene_of("slider-crank", 0.5, dice.vector(9),
                            {dice.body("rod"), dice.body("piston"), dice.body("crank")}, {rail, motor, pin, wrist});
  if (dice.one_in(2))
    given.scene.joint_forces.push_back(JointSpring{0, 0, dice.in(0, 20), dice.in(0, 2), dice.in(0, 2)});
  return given;
}

Scenario random_four_bar(Dice& dice) {
  const double l = 0.75, angle = dice.in(0.2, 1.2), rate = dice.in(-2, 2);
  std::vector<Body> bodies{dice.body("bar0"), dice.body("link"), dice.body("bar1")};
  Joint foot0 = with_start(joint("foot0", JointKind::hinge, -1, 0, {0, 0, 0}, {0, -l, 0}), angle, rate);
  Joint foot1 = with_start(joint("foot1", JointKind::hinge, -1, 2, {1.25, 0, 0}, {0.25, -0.25, 0}), angle, rate);
  Joint left = with_start(joint("left", JointKind::hinge, 0, 1, {0, 0.25, 0}, {-1, 0.125, 0}, {0, 0, -1}), angle, rate);
  Joint right = joint("right", JointKind::hinge, 1, 2, {0.25, 0.125, 0}, {0.25, 0.75, 0});
  right.closes_loop = true;
  right.coordinates[0] = angle;
  right.rates[0] = rate;
  return scene_of("four-bar", 0.25, dice.vector(9), bodies, {foot0, foot1, left, right});
}

// The universal joint ties the shafts in either order, and closes the loop or places the second shaft.
Scenario random_shafts(Dice& dice) {
  const double bend = dice.in(-1.2, 1.2), W = dice.in(-5, 5), half = bend / 2;
  Body first = dice.body("first"), second = dice.body("second");
  Joint motor = joint("motor", JointKind::hinge, -1, 0, {0, 0, -0.5}, {0, 0, 0.125});
  motor.driven_rate = motor.rates[0] = W;
  Joint bearing = joint("bearing", JointKind::hinge, -1, 1, {0, 0, 0}, {0, 0, -0.75});
  bearing.frame_wxyz = {std::cos(half), std::sin(half), 0, 0};
  Joint cross = joint("cross", JointKind::universal, 0, 1, {0, 0, 0.625}, {0, 0, -0.75});
  cross.axes_body = {Real3{1, 0, 0}, Real3{0, 1, 0}};
  cross.coordinates = {bend, 0, 0, 0};
  bearing.rates[0] = W * std::cos(bend);
  if (dice.one_in(2)) {
    cross.closes_loop = true;
  } else {
    bearing.closes_loop = bearing.assemble = true;
  }
  Scenario given = scene_of("hooke-shaft", 0.75, dice.one_in(2) ? Real3{0, 0, 0} : dice.vector(9), {first, second},
                            {motor, bearing, cross});
  given.scene.joint_forces.push_back(JointTorque{1, 0, dice.in(-3, 3), dice.in(0, 2), 0.3, {}});
  given.scene.joint_forces.push_back(JointSpring{0, 0, dice.in(0, 2), 0.1, dice.in(0, 1)});
  return given;
}

Scenario random_welds(Dice& dice) {
  std::vector<Body> bodies{dice.body("base"), dice.body("arm"), dice.body("tip"), dice.body("other"), dice.body("fin")};
  for (const int root : {0, 3}) {
    bodies[root].position_m = dice.vector(1);
    bodies[root].orientation_wxyz = dice.quaternion();
    bodies[root].velocity_m_per_s = dice.vector(2);
    bodies[root].angular_velocity_body_rad_per_s = dice.vector(4);
  }
  std::vector<Joint> joints{joint("tip-weld", JointKind::fixed, 1, 2, dice.vector(0.5), dice.vector(0.5)),
                            joint("arm-weld", JointKind::fixed, 0, 1, dice.vector(0.5), dice.vector(0.5)),
                            joint("fin-weld", JointKind::fixed, 3, 4, dice.vector(0.5), dice.vector(0.5))};
  for (Joint& each : joints) each.frame_wxyz = dice.quaternion();
  return scene_of("welded-bodies", 0.75, dice.vector(9), bodies, joints);
}

template <std::size_t n>
bool apart(const std::array<Wide, n>& a, const std::array<Wide, n>& b, const std::array<Wide, n>& p,
           const std::array<Wide, n>& q, Wide sign = 1) {
  for (std::size_t i = 0; i < n; ++i)
    if (fabsq(a[i] - sign * b[i]) > p[i] + q[i]) return true;  // not reported: not compared
  return false;
}

// Differs by more than both bars: what, else empty.
std::string differs(const Scene& scene, const Truth& a, const Truth& b) {
  for (std::size_t k = 0; k < a.values.size(); ++k) {
    const SampleView x = a.values[k], y = b.values[k], p = a.bars[k], q = b.bars[k];
    for (std::size_t i = 0; i < x.bodies.size(); ++i) {
      if (scene.bodies[i].fixed) continue;
      const BodySample &m = x.bodies[i], &n = y.bodies[i], &e = p.bodies[i], &f = q.bodies[i];
      Wide along = 0;
      for (std::size_t c = 0; c < 4; ++c) along += m.q_wxyz[c] * n.q_wxyz[c];
      if (apart(m.p_m, n.p_m, e.p_m, f.p_m)) return "position of " + scene.bodies[i].name;
      if (apart(m.q_wxyz, n.q_wxyz, e.q_wxyz, f.q_wxyz, along < 0 ? -1 : 1))
        return "attitude of " + scene.bodies[i].name;
      if (apart(m.v_m_per_s, n.v_m_per_s, e.v_m_per_s, f.v_m_per_s)) return "velocity";
      if (apart(m.w_rad_per_s, n.w_rad_per_s, e.w_rad_per_s, f.w_rad_per_s)) return "body rate";
    }
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const JointSample &m = x.joints[j], &n = y.joints[j], &e = p.joints[j], &f = q.joints[j];
      if (apart(m.q, n.q, e.q, f.q)) return "coordinate of " + scene.joints[j].name;
      if (apart(m.u, n.u, e.u, f.u)) return "rate of " + scene.joints[j].name;
      if (apart(m.force_N, n.force_N, e.force_N, f.force_N)) return "force of " + scene.joints[j].name;
      if (apart(m.torque_N_m, n.torque_N_m, e.torque_N_m, f.torque_N_m)) return "torque of " + scene.joints[j].name;
      if (apart(m.applied, n.applied, e.applied, f.applied)) return "motor of " + scene.joints[j].name;
      if (m.not_unique != n.not_unique) return "what is unique of " + scene.joints[j].name;
    }
  }
  return "";
}

void compare(Scenario (*random)(Dice&), unsigned seed, int scenes, int least) {
  Dice dice{std::mt19937(seed)};
  int answered = 0;
  for (int k = 0; k < scenes; ++k) {
    const Scenario given = random(dice);
    const Truth truth = closed_form_truth(given, 3);
    INFO(given.truth.solution << " " << k << ": " << truth.outcome.reason);
    if (truth.outcome.status != Status::ok) {
      CHECK(truth.outcome.status == Status::unsupported);
      continue;
    }
    const Truth certified = extended_truth(given, 3);
    INFO("the certified solver: " << certified.outcome.reason);
    if (certified.outcome.status != Status::ok) continue;
    ++answered;
    INFO(differs(given.scene, truth, certified));
    CHECK(differs(given.scene, truth, certified).empty());
  }
  CHECK(answered >= least);
}

}  // namespace

TEST_CASE("Random pendulums and tops") {
  compare(random_pendulum, 1, 12, 10);
  compare(random_top, 2, 12, 10);
}
TEST_CASE("Random driven mechanisms") {
  compare(random_rod, 5, 10, 8);
  compare(random_crank, 6, 6, 5);
}
TEST_CASE("Random shafts with a universal joint") { compare(random_shafts, 8, 8, 6); }
TEST_CASE("Random welded bodies") { compare(random_welds, 9, 8, 7); }
TEST_CASE("Random four-bars") { compare(random_four_bar, 7, 5, 4); }
