// Linear joints, stops, driven mechanisms, four-bars and Atwood's machine.
#include <catch2/catch.hpp>
#include <random>

#include "joint_scenes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

double worst(const Scenario& given, std::int64_t samples) {
  const Truth truth = closed_form_truth(given, samples);
  INFO(truth.outcome.reason);
  CHECK(truth.outcome.status == Status::ok);
  if (truth.outcome.status != Status::ok) return HUGE_VAL;
  const Deviations found = deviations(given, truth);
  INFO("velocity " << found.velocity << ", attitude " << found.attitude << ", force " << found.force << ", torque "
                   << found.torque << ", gap " << found.gap << ", rate " << found.rate);
  CHECK(found.worst() < 1e-18);
  return found.worst();
}

Body uneven(const std::string& name) { return solid(name, 2, {1, 1.5, 2}, {0, 0, 0}); }

std::string why(const Scenario& given) {
  const Truth truth = closed_form_truth(given, 8);
  CHECK(truth.outcome.status == Status::unsupported);
  return truth.outcome.reason;
}

// Crank along x at the start, rod of length 2 to a piston on the x axis.
Scenario slider_crank(double offset) {
  Body crank = solid("crank", 1, {0.1, 0.2, 0.3}, {0, 0, 0}), rod = solid("rod", 2, {0.2, 0.5, 0.6}, {0, 0, 0}),
       piston = solid("piston", 3, {0.4, 0.5, 0.6}, {0, 0, 0});
  Joint motor = with_start(joint("motor", JointKind::hinge, -1, 0, {0, 0, 0}, {-0.25, 0, 0}), 0.5, 3);
  motor.driven_rate = 3;
  // The rod's angle in the world is asin((h - A_y) / L).
  const double phi = std::asin((offset - 0.5 * std::sin(0.5)) / 2);
  Joint pin = with_start(joint("pin", JointKind::hinge, 0, 1, {0.25, 0, 0}, {-1.25, 0, 0}), phi - 0.5,
                         -1.5 * std::cos(0.5) / (2 * std::cos(phi)) - 3);
  Joint wrist = with_start(joint("wrist", JointKind::hinge, 1, 2, {0.75, 0, 0}, {0.125, 0, 0}, {0, 0, -1}), phi,
                           -1.5 * std::cos(0.5) / (2 * std::cos(phi)));
  Joint slide = joint("slide", JointKind::slider, -1, 2, {0, offset, 0}, {0.125, 0, 0}, {1, 0, 0});
  slide.closes_loop = true;
  return mechanism("slider-crank", 2, {crank, rod, piston}, {motor, pin, wrist, slide}, {0, -9.8, 0});
}

// n four-bars of rods of length 1, from the upward vertical; every bar after the first closes a loop.
Scenario four_bars(int n, double angle, double rate) {
  Scenario given = mechanism("four-bar", 2, {}, {}, {0, -9.81, 0});
  const Real3 moments{1.0 / 12, 0.001, 1.0 / 12}, across{0.001, 1.0 / 12, 1.0 / 12};
  for (int k = 0; k <= n; ++k) {
    given.scene.bodies.push_back(solid("bar" + std::to_string(k), 1, moments, {0, 0, 0}));
    Joint foot = with_start(
        joint("foot" + std::to_string(k), JointKind::hinge, -1, 2 * k, {double(k), 0, 0}, {0, -0.5, 0}), angle, rate);
    foot.closes_loop = k > 0;
    given.scene.joints.push_back(foot);
    if (k == n) break;
    given.scene.bodies.push_back(solid("link" + std::to_string(k), 1, across, {0, 0, 0}));
    given.scene.joints.push_back(
        with_start(joint("left" + std::to_string(k), JointKind::hinge, 2 * k, 2 * k + 1, {0, 0.5, 0}, {-0.5, 0, 0}),
                   -angle, -rate));
    given.scene.joints.push_back(with_start(joint("right" + std::to_string(k), JointKind::hinge, 2 * k + 1, 2 * k + 2,
                                                  {0.5, 0, 0}, {0, 0.5, 0}, {0, 0, -1}),
                                            -angle, -rate));
  }
  return given;
}

}  // namespace

TEST_CASE("Flywheels, springs, dampers and motors on hinges and sliders") {
  const auto hinge = [](double q, double u) {
    return with_start(joint("axle", JointKind::hinge, -1, 0, {1, 0, 0}, {0, 0.25, 0.5}, {0, 0, 1}), q, u);
  };
  const auto slider = [](double q, double u) {
    return with_start(joint("rail", JointKind::slider, -1, 0, {1, 0, 0}, {0, 0.25, 0.5}, {0.6, 0, 0.8}), q, u);
  };
  for (const Joint& axle : {hinge(0.5, -1), slider(0.5, -1)}) {
    Scenario given = mechanism("linear-joint", 3, {uneven("wheel")}, {axle});
    CHECK(worst(given, 512) < 1e-18);
    given.scene.joint_forces = {JointTorque{0, 0, 1.5, 0, 0.25, {}}};
    CHECK(worst(given, 512) < 1e-18);
    given.scene.joint_forces.push_back(JointSpring{0, 0, 0, 0, 0.75});
    CHECK(worst(given, 512) < 1e-18);
    given.scene.joint_forces.push_back(JointSpring{0, 0, 20, 0.25, 0});
    CHECK(worst(given, 1024) < 1e-18);
    given.scene.joint_forces.push_back(JointTorque{0, 0, 2, 5, 0.25, {}});
    CHECK(worst(given, 1024) < 1e-18);
    given.scene.joint_forces.push_back(JointSpring{0, 0, 0, 0, 40});
    CHECK(worst(given, 2048) < 1e-18);
    given.scene.joint_forces = {JointTorque{0, 0, 2, 5, 0.25, {}}};
    CHECK(worst(given, 1024) < 1e-18);
  }
  Scenario resonant = mechanism("linear-joint", 3, {uneven("block")}, {slider(0, 0)});
  resonant.scene.joint_forces = {JointSpring{0, 0, 18, 0, 0}, JointTorque{0, 0, 2, 3, 0, {}}};
  CHECK(worst(resonant, 1024) < 1e-18);
  std::get<JointTorque>(resonant.scene.joint_forces[1]).angular_frequency_rad_per_s = 3.0000001;
  CHECK_THAT(why(resonant), Catch::Contains("resonance"));
  Scenario tilted = mechanism("linear-joint", 3, {uneven("wheel")}, {hinge(0.5, -1)}, {0, 1e-9, -9.8});
  CHECK_THAT(why(tilted), Catch::Contains("gravity has a moment about the hinge `axle`"));
}

TEST_CASE("A body slides on a rod that is turned, straight and oblique, with and without gravity across the axis") {
  Joint motor = with_start(joint("motor", JointKind::hinge, -1, 0, {0, 0, 1}, {0.25, 0, 0}, {0, 0, 1}), 0.5, 2);
  motor.driven_rate = 2;
  const Joint straight =
      with_start(joint("bead", JointKind::slider, 0, 1, {0.25, 0, 0}, {0, 0, 0}, {1, 0, 0}), 0.5, -0.25);
  Joint oblique =
      with_start(joint("bead", JointKind::slider, 0, 1, {0.25, 0.5, 0}, {0.25, -0.125, 0}, {0.6, 0, 0.8}), 0.5, 0);
  oblique.frame_wxyz = {0.8, 0, 0.6, 0};
  for (const Joint& slide : {straight, oblique})
    for (const Real3& gravity : {Real3{0, 0, 0}, down, Real3{3, -9.8, 1}})
      CHECK(worst(mechanism("turning-rod", 2, {uneven("rod"), uneven("bead")}, {motor, slide}, gravity), 512) < 1e-18);
  // Through the axis without gravity: r = r0 cosh W t.
  Scenario given = mechanism(
      "turning-rod", 2, {uneven("rod"), uneven("bead")},
      {motor, with_start(joint("bead", JointKind::slider, 0, 1, {-0.25, 0, 0}, {0, 0, 0}, {1, 0, 0}), 0.5, 0)},
      {0, 0, 0});
  given.scene.joints[0].anchors_body_m[1] = {-0.25, 0, 0};
  const Truth truth = closed_form_truth(given, 16);
  for (const SampleView sample : truth.values)
    CHECK(static_cast<double>(fabsq(sample.joints[1].q[0] / coshq(2 * sample.t_s) - Wide(0.5))) < 1e-31);
}

TEST_CASE("A slider-crank at a constant rate, in line and offset") {
  CHECK(worst(slider_crank(0), 2048) < 1e-18);
  CHECK(worst(slider_crank(0.375), 2048) < 1e-18);
  Scenario given = slider_crank(0);
  given.scene.joint_forces = {JointSpring{3, 0, 30, 1.5, 2}, JointTorque{0, 0, 5, 0, 0, {}}};
  CHECK(worst(given, 2048) < 1e-18);
  // Out of the plane the mechanism is over-constrained: forces along z, torques about x and y.
  const Truth truth = closed_form_truth(slider_crank(0.375), 4);
  REQUIRE(truth.outcome.status == Status::ok);
  for (const JointSample& at : truth.values[1].joints) CHECK(at.not_unique == (4u | 8u | 16u));
  // In-line: x = A cos + sqrt(L^2 - A^2 sin^2).
  const Truth line = closed_form_truth(slider_crank(0), 16);
  for (const SampleView sample : line.values) {
    const Wide angle = Wide(0.5) + 3 * sample.t_s, s = sinq(angle) / 2;
    CHECK(static_cast<double>(fabsq(sample.joints[3].q[0] - cosq(angle) / 2 - sqrtq(4 - s * s))) < 1e-30);
  }
  Scenario shorter = slider_crank(0);
  shorter.scene.joints[1].anchors_body_m[1] = {0.25, 0, 0};
  CHECK_THAT(why(shorter), Catch::Contains("closed form `slider-crank`"));
}

TEST_CASE("N four-bars have the motion of one pendulum, N = 1, 2, 40") {
  for (const int n : {1, 2}) {
    CHECK(worst(four_bars(n, 0.25, -1), 1024) < 1e-18);
    CHECK(worst(four_bars(n, 2.5, 0.5), 1024) < 1e-18);
  }
  for (const int n : {1, 2, 40}) {
    const Scenario given = four_bars(n, 0.5, -2);
    const Truth truth = closed_form_truth(given, n == 40 ? 256 : 1024);
    INFO(truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    const Wide h = Wide(given.t_end_s) / static_cast<Wide>(truth.values.size() - 1);
    const Wide factor = (Wide(n + 1) / 2 + n) / (Wide(n + 1) / 3 + n);
    // The moments are the doubles next to 1/12.
    const Wide inertia = (n + 1) * (Wide(1.0 / 12) + Wide(0.25)) + n,
               exact = Wide(9.81) * (Wide(n + 1) / 2 + n) / inertia;
    CHECK(static_cast<double>(fabsq(exact / (Wide(9.81) * factor) - 1)) < 1e-15);
    for (std::size_t k = 6; k + 6 < truth.values.size(); k += 7) {
      const Wide slope = derivative<1>(truth.values, k, h,
                                       [](const SampleView& s) { return std::array<Wide, 1>{s.joints[0].u[0]}; })[0];
      CHECK(static_cast<double>(fabsq(slope - exact * sinq(truth.values[k].joints[0].q[0]))) <
            (n == 40 ? 1e-12 : 1e-18));
    }
  }
}

TEST_CASE("Four-bars refuse bars of other lengths, crossed bars and bars apart") {
  Scenario given = four_bars(1, 0.5, -2);
  given.scene.joints[0].anchors_body_m[1] = {0, -0.5078125, 0};
  CHECK(closed_form_truth(given, 4).outcome.status == Status::unsupported);
  given = four_bars(2, 0.5, -2);
  given.scene.joints.erase(given.scene.joints.begin() + 2);
  given.scene.joints[2].closes_loop = false;
  CHECK_THAT(why(given), Catch::Contains("`link0` does not join two parallel bars"));
}

TEST_CASE("A door falls on its stop, bounces and rests; between two stops without force it goes on") {
  Joint rail = with_start(joint("rail", JointKind::slider, -1, 0, {0, 0, 0}, {0, 0, 0}), 1, 0);
  rail.limits = JointLimits{0, 2, 0.5};
  Scenario drop = mechanism("joint-stop", 3, {uneven("block")}, {rail}, {0, 0, -8});
  const Truth truth = closed_form_truth(drop, 32);
  REQUIRE(truth.outcome.status == Status::ok);
  // t1 = sqrt(2 / 8) = 0.5, V = 4; flights take 2 V e^k / 8: rest at 0.5 + (0.5 + 0.25 + ...) = 1.5.
  REQUIRE(truth.events.size() > 20);
  CHECK(static_cast<double>(truth.events[0].t_s) == 0.5);
  CHECK(static_cast<double>(truth.events[0].vn_before_m_per_s) == -4);
  CHECK(static_cast<double>(truth.events[0].vn_after_m_per_s) == 2);
  CHECK(static_cast<double>(truth.events[0].impulse_n_N_s) == 12);
  CHECK(static_cast<double>(truth.events[1].t_s) == 1);
  CHECK(truth.events[0].body_a == -1);
  CHECK(truth.events.back().kind == EventKind::rest);
  CHECK(static_cast<double>(fabsq(truth.events.back().t_s - Wide(1.5))) < 1e-30);
  for (const SampleView sample : truth.values) {
    const auto t = static_cast<double>(sample.t_s);
    if (t < 0.5) CHECK(static_cast<double>(sample.joints[0].q[0]) == 1 - 4 * t * t);
    if (t > 0.5 && t < 1)
      CHECK(static_cast<double>(
                fabsq(sample.joints[0].q[0] - (2 * (sample.t_s - Wide(0.5)) -
                                               4 * (sample.t_s - Wide(0.5)) * (sample.t_s - Wide(0.5))))) < 1e-30);
    if (t >= 1.5) CHECK(static_cast<double>(fabsq(sample.joints[0].q[0]) + fabsq(sample.joints[0].u[0])) == 0);
    if (t < 0.5) CHECK(static_cast<double>(sample.joints[0].stop[0]) == 0);
    if (t > 1.5) CHECK(static_cast<double>(fabsq(sample.joints[0].stop[0] - 16)) < 1e-30);  // 2 kg at 8 m/s^2
  }

  // A hinge with a motor: J = 2 + 2 / 16, between stops 1 apart, e = 1 at both.
  Joint axle = with_start(joint("axle", JointKind::hinge, -1, 0, {0, 0, 0}, {0.25, 0, 0}), 0.25, 1);
  axle.limits = JointLimits{0, 1, 1};
  Scenario door = mechanism("joint-stop", 3, {uneven("door")}, {axle});
  const Truth idle = closed_form_truth(door, 32);
  REQUIRE(idle.outcome.status == Status::ok);
  REQUIRE(idle.events.size() == 3);
  CHECK(static_cast<double>(idle.events[0].t_s) == 0.75);
  CHECK(static_cast<double>(idle.events[1].t_s) == 1.75);
  CHECK(static_cast<double>(idle.events[2].t_s) == 2.75);
  CHECK(static_cast<double>(idle.events[0].impulse_n_N_s) == 4.25);
  CHECK(static_cast<double>(idle.events[0].normal[2]) == -1);
  door.scene.joint_forces = {JointTorque{0, 0, 4.25, 0, 0, {}}};  // q'' = 2: from 0.25 at 1: 0.25 + t + t^2 = 1
  const Truth pushed = closed_form_truth(door, 32);
  REQUIRE(pushed.outcome.status == Status::ok);
  CHECK(static_cast<double>(fabsq(pushed.events[0].t_s - Wide(0.5))) < 1e-30);
  CHECK(static_cast<double>(fabsq(pushed.events[0].vn_after_m_per_s - 2)) < 1e-30);

  door.scene.joints[0].coordinates[0] = 1.5;
  CHECK_THAT(why(door), Catch::Contains("outside its limits"));
  door.scene.joints[0].limits.reset();
  CHECK_THAT(why(door), Catch::Contains("no limits"));
}

TEST_CASE("A return to an elastic stop at which the motion started at rest is no impact") {
  std::mt19937 draw(5);
  std::uniform_real_distribution<double> any(0.5, 3);
  for (int trial = 0; trial < 200; ++trial) {
    const double width = any(draw), g = any(draw), lower = -any(draw);
    Joint rail = with_start(joint("rail", JointKind::slider, -1, 0, {0, 0, 0}, {0, 0, 0}), lower, 0);
    rail.limits = JointLimits{lower, lower + width, 1};
    const double there = std::sqrt(2 * (rail.limits->upper - lower) / g);  // from one stop to the other
    const Scenario given = mechanism("joint-stop", 10 * there, {uneven("block")}, {rail}, {0, 0, g});
    const Truth truth = closed_form_truth(given, 8);
    INFO("width " << width << " m, g " << g << " m/s^2, lower " << lower << " m: " << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    REQUIRE(truth.events.size() == 5);
    for (std::size_t k = 0; k < 5; ++k)
      CHECK(static_cast<double>(truth.events[k].t_s) ==
            Approx((2 * static_cast<double>(k) + 1) * there).epsilon(1e-14));
  }
}

TEST_CASE("Atwood's machine with light and heavy pulleys") {
  Scenario given = scenario("atwood-machine", 1);
  given.scene.gravity_m_per_s2 = {0, 0, -10};
  given.scene.bodies = {solid("left", 1, {0.1, 0.1, 0.1}, {0, 0, 0}), solid("right", 3, {0.1, 0.1, 0.1}, {0, 0, 0})};
  given.scene.bodies[0].position_m = {-0.25, 0, -4};
  given.scene.bodies[1].position_m = {0.25, 0, -8};
  given.scene.bodies[0].velocity_m_per_s = {0, 0, -2};
  given.scene.bodies[1].velocity_m_per_s = {0, 0, 2};
  // On the side x = -0.25 the rope goes up: axis x (point - axle) = y x (-x) = z.
  Rope rope{"rope", {0, 1}, {{{0, 0, 0.5}, {0, 0, 0.5}}}, {Pulley{{0, 0, 0}, {0, 1, 0}, 0.25, 0, 0.5}}};
  given.scene.ropes = {rope};
  Truth truth = closed_form_truth(given, 4);
  INFO(truth.outcome.reason);
  REQUIRE(truth.outcome.status == Status::ok);  // s'' = 2 * 10 / 4 = 5; s = -2 t + 5 t^2 / 2
  CHECK(static_cast<double>(truth.values[4].bodies[0].p_m[2]) == -3.5);
  CHECK(static_cast<double>(truth.values[4].bodies[1].p_m[2]) == -8.5);
  CHECK(static_cast<double>(truth.values[4].bodies[1].v_m_per_s[2]) == -3);
  CHECK(static_cast<double>(truth.values[4].ropes[0].tension_N) == 15);
  CHECK(static_cast<double>(truth.values[4].ropes[0].pulley_angle_rad[0]) == 2.5);
  given.scene.ropes[0].over[0].inertia_kg_m2 = 0.0625;  // I / r^2 = 1: s'' = 4
  truth = closed_form_truth(given, 4);
  CHECK(static_cast<double>(fabsq(truth.values[4].bodies[0].p_m[2] + 4)) < 1e-30);
  CHECK(static_cast<double>(fabsq(truth.values[4].ropes[0].tension_N - 14)) < 1e-30);
  given.scene.ropes[0].over[0].axis = {0, -1, 0};
  CHECK_THAT(why(given), Catch::Contains("does not hang straight below"));
  given.scene.ropes = {rope};
  given.t_end_s = 2.5;  // s = -5 + 15.6 > 3.5: it is at the pulley before
  CHECK_THAT(why(given), Catch::Contains("reaches its pulley"));
  given.t_end_s = 1;
  given.scene.bodies[1].velocity_m_per_s[2] = 2.25;
  CHECK_THAT(why(given), Catch::Contains("same speed"));
}

TEST_CASE("Every other closed form refuses a joint, a rope and a joint's torque, by name") {
  for (const std::string& id : closed_form_ids()) {
    INFO(id);
    Scenario given = scenario(id, 1);
    given.scene.bodies = {uneven("a"), uneven("b"), uneven("c")};
    given.scene.joints = {joint("weld", JointKind::fixed, 0, 1, {1, 0, 0}, {0, 0, 0})};
    if (id != "welded-bodies") CHECK_THAT(why(given), Catch::Contains("`weld`"));
    given.scene.joints = {joint("sleeve", JointKind::cylindrical, 0, 1, {1, 0, 0}, {0, 0, 0})};
    CHECK_THAT(why(given), Catch::Contains("`sleeve`"));
    given.scene.joints[0].kind = JointKind::universal;
    if (id != "hooke-shaft") CHECK_THAT(why(given), Catch::Contains("`sleeve`"));
    given.scene.joints = {joint("pin", JointKind::hinge, 0, 1, {1, 0, 0}, {0, 0, 0})};
    given.scene.joint_forces = {JointTorque{0, 0, 1, 0, 0, {{0, 1}}}};
    CHECK_THAT(why(given), Catch::Contains("`pin`"));
    given.scene.joints.clear();
    given.scene.joint_forces.clear();
    given.scene.ropes = {Rope{"line", {0, 1}, {}, {}}};
    if (id != "atwood-machine") CHECK_THAT(why(given), Catch::Contains("the rope `line` is not covered"));
    else CHECK_THAT(why(given), Catch::Contains("expected a rope and gravity"));
  }
}
