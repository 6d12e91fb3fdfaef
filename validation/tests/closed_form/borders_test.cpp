// Near the limits of its validity a closed form refuses, or its bar contains the motions on both sides.
#include <catch2/catch.hpp>

#include "scenes.hpp"
#include "validation/tests/catalogued.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

Body ground() {
  Body made = point("ground", 0, {0, 0, 0}, {0, 0, 0});
  made.shape = Plane{{0, 0, 1}, 0};
  made.fixed = true;
  return made;
}

Scenario on_ground(const std::string& solution, double friction, double t_end_s, const Body& body) {
  Scenario given = scenario(solution, t_end_s);
  given.scene.gravity_m_per_s2 = {0, 0, -9.81};
  given.scene.pairs[0].friction = friction;
  given.scene.bodies = {ground(), body};
  return given;
}

double number(Wide x) { return static_cast<double>(x); }

}  // namespace

TEST_CASE(
    "A rod struck slightly off its plane of symmetry is refused: rotation about the middle axis amplifies the offset") {
  Scenario given = catalogued("struck-rod-box");
  given.scene.bodies[0].inertia_kg_m2 = {0.1, 0, 0, 0, 0.15, 0, 0, 0, 0.2};
  REQUIRE(closed_form_truth(given, 8).outcome.reason == "");
  for (const double aside : {1e-15, 1e-18, 1e-25, 1e-30}) {
    Scenario off = given;
    off.scene.bodies[1].position_m[1] = aside;
    const Truth truth = closed_form_truth(off, 8);
    INFO(aside << ": " << truth.outcome.reason);
    CHECK(truth.outcome.status == Status::unsupported);
  }
}

TEST_CASE("A rod and a ball that overlap at the start are refused") {
  for (const char* id : {"struck-rod", "struck-rod-box"}) {
    Scenario given = catalogued(id);
    given.scene.bodies[1].position_m = given.scene.bodies[0].position_m;
    given.scene.bodies[1].position_m[0] -= 0.001;
    CHECK_THAT(closed_form_truth(given, 8).outcome.reason, Catch::Contains("overlap"));
  }
}

TEST_CASE("A ball that rolls except for 2^-49 of slip: the bar contains rolling and slipping") {
  for (const double friction : {0.0, 0.25}) {
    Body made = ball("ball", 1, 0.5, {0, 0, 0.5}, {1, 0, 0});
    made.angular_velocity_body_rad_per_s = {0, 2 * (1 - 0x1p-49), 0};
    const Truth truth = closed_form_truth(on_ground("slide-or-roll", friction, 4, made), 8);
    INFO(truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    // Without friction the spin stays; with it the slip ends at (5 v + 2 r w) / 7.
    const Wide w = friction == 0 ? Wide(made.angular_velocity_body_rad_per_s[1])
                                 : (5 + Wide(made.angular_velocity_body_rad_per_s[1])) / Wide(3.5);
    const BodySample &end = truth.values.back().bodies[1], &bar = truth.bars.back().bodies[1];
    CHECK(number(fabsq(end.w_rad_per_s[1] - w)) < number(bar.w_rad_per_s[1]));
    const Wide v = friction == 0 ? Wide(1) : w / 2;
    CHECK(number(fabsq(end.v_m_per_s[0] - v)) < number(bar.v_m_per_s[0]));
    CHECK(number(bar.w_rad_per_s[1]) < 1e-13);
  }
}

TEST_CASE("A slope below the round-off of its normal: the bar contains the level plane and the slope") {
  Body made = ball("ball", 1, 0.5, {0, 0, 0.5}, {0, 0, 0});
  Scenario given = on_ground("slide-or-roll", 0, 100, made);
  given.scene.gravity_m_per_s2 = {1e-14, 0, -9.81};
  const Truth truth = closed_form_truth(given, 8);
  REQUIRE(truth.outcome.reason == "");
  const BodySample &end = truth.values.back().bodies[1], &bar = truth.bars.back().bodies[1];
  CHECK(number(fabsq(end.p_m[0] - Wide(1e-14) * 5000)) < number(bar.p_m[0]));
  CHECK(number(fabsq(end.v_m_per_s[0] - Wide(1e-14) * 100)) < number(bar.v_m_per_s[0]));
}

TEST_CASE("Overlaps are compared with the size of the bodies, for every size and position") {
  for (const double size : {1e-12, 1e-6, 1.0, 1e9})
    for (const double share : {0.9, 0.1, 1e-6}) {
      Scenario given = scenario("sphere-impact", 1);
      given.scene.bodies = {ball("a", 1, size, {0, 0, 0}, {0, 0, 0}),
                            ball("b", 1, size, {2 * size * (1 - share), 0, 0}, {-size, 0, 0})};
      for (const char* solution : {"sphere-impact", "ball-flights"}) {
        given.truth.solution = solution;
        CHECK_THAT(closed_form_truth(given, 4).outcome.reason, Catch::Contains("overlap"));
      }
    }
  // A ball of 1e-12 m far out: what the round-off of its place amounts to there is more than the ball.
  Body tiny = ball("tiny", 1, 1e-12, {1e4, 0, 0.2e-12}, {0, 0, 0});
  for (const char* solution : {"bounce", "ball-flights", "slide-or-roll", "rest"}) {
    const Truth truth = closed_form_truth(on_ground(solution, 0, 1, tiny), 4);
    INFO(solution);
    CHECK(truth.outcome.status == Status::unsupported);
  }
}

TEST_CASE("A ball that lies on the ground lies there whatever its restitution") {
  for (const double e : {0.0, 0.5, 1.0}) {
    Scenario given = on_ground("bounce", 0, 2, ball("ball", 1, 0.5, {0, 0, 0.5}, {0, 0, 0}));
    given.scene.pairs[0].restitution = e;
    const Truth truth = closed_form_truth(given, 4);
    if (truth.outcome.status == Status::ok) CHECK(truth.values.back().bodies[1].p_m[2] == Wide(0.5));
  }
}

TEST_CASE("A thrust or a spin slightly off the axis is refused, and so is a rotation without end") {
  Scenario given = scenario("axis-torque", 200);
  given.scene.bodies = {solid("ship", 5, {2, 3, 4}, {0, 1, 0})};
  given.scene.forces = {Thruster{0, {1, 0, 0}, {0, 0, -1}, 0.001, {}}};
  REQUIRE(closed_form_truth(given, 4).outcome.reason == "");
  given.scene.bodies[0].angular_velocity_body_rad_per_s[0] = 1e-40;
  CHECK_THAT(closed_form_truth(given, 4).outcome.reason, Catch::Contains("principal axis"));
  given.scene.bodies[0].angular_velocity_body_rad_per_s = {0, 1, 0};
  given.scene.forces = {Thruster{0, {1, 1e-40, 0}, {0, 0, -1}, 0.001, {}}};
  CHECK_THAT(closed_form_truth(given, 4).outcome.reason, Catch::Contains("axis of spin"));
  given.scene.forces = {Thruster{0, {1, 0, 0}, {0, 0, -1}, 1e12, {}}};
  CHECK_THAT(closed_form_truth(given, 4).outcome.reason, Catch::Contains("1e6 rad"));
}

TEST_CASE("Equilibrium at its limits is refused: a slope beside the friction angle, a ball on a slope of 1e-9") {
  Body box = solid("box", 2, {0.03, 0.03, 0.03}, {0, 0, 0});
  box.shape = Box{{0.2, 0.2, 0.1}};
  box.position_m = {0, 0, 0.1};
  Scenario given = on_ground("rest", 0.5, 10, box);
  given.scene.gravity_m_per_s2 = {0.5 * 9.81 * (1 - 1e-3), 0, -9.81};
  CHECK(closed_form_truth(given, 4).outcome.reason == "");
  given.scene.gravity_m_per_s2 = {0.5 * 9.81 * (1 + 1e-8), 0, -9.81};
  CHECK_THAT(closed_form_truth(given, 4).outcome.reason, Catch::Contains("`box`"));
  given = on_ground("rest", 0.5, 10, ball("ball", 1, 0.5, {0, 0, 0.5}, {0, 0, 0}));
  CHECK(closed_form_truth(given, 4).outcome.reason == "");
  given.scene.gravity_m_per_s2 = {9.81e-9, 0, -9.81};
  CHECK_THAT(closed_form_truth(given, 4).outcome.reason, Catch::Contains("`ball`"));
}

TEST_CASE("An oscillator that every sample finds at rest is answered") {
  Scenario given = scenario("oscillator", 3);
  given.samples = 3;
  given.scene.bodies = {point("bob", 1, {1, 0, 0}, {0, 0, 0})};
  given.scene.forces = {Spring{{0}, {0, 0, 0}, 39.47841760435743, 0, 0, {}}};
  const Truth truth = closed_form_truth(given, 3);
  REQUIRE(truth.outcome.reason == "");
  CHECK(truth.values[3].bodies[0].p_m[0] == Approx(1).epsilon(1e-14));
  CHECK(truth.bars[3].bodies[0].v_m_per_s[0] < 1e-29);
}

TEST_CASE("Beside resonance, where long double sees resonance and quad does not, an oscillator is refused") {
  for (int e = 21; e <= 52; ++e) {
    const double part = std::ldexp(1.0, -e);
    Scenario given = scenario("oscillator", 4);
    given.scene.bodies = {point("bob", 1, {1, 0, 0}, {0, 0, 0})};
    given.scene.forces = {Spring{{0}, {0, 0, 0}, 1 + 2 * part, 0, 0, {}}, Drive{{0}, {1, 0, 0}, 1 + part, 0.3}};
    INFO("2^-" << e);
    CHECK_THAT(closed_form_truth(given, 4).outcome.reason, Catch::Contains("resonance"));
    given.scene.forces = {Spring{{0}, {0, 0, 0}, (1 + part) * (1 + part), 0, 0, {}},
                          Drive{{0}, {1, 0, 0}, 1 + part, 0.3}};
    if (e <= 26) CHECK(closed_form_truth(given, 4).outcome.reason == "");  // the square is a double: resonance itself
  }
}

TEST_CASE(
    "Two balls that overlap by the round-off of their places and slide past each other exchange their speeds along the line") {
  for (const double approach : {0.1, 1e-3, 1e-6})
    for (const char* solution : {"sphere-impact", "ball-flights"}) {
      Scenario given = scenario(solution, 1);
      given.scene.pairs[0].restitution = 1;
      given.scene.bodies = {ball("a", 1, 0.5, {0, 0, 0}, {0, 0, 0}),
                            ball("b", 1, 0.5, {0.9999999999999997, 0, 0}, {-approach, 1, 0})};
      const Truth truth = closed_form_truth(given, 1);
      INFO(solution << ", " << approach << ": " << truth.outcome.reason);
      REQUIRE(truth.outcome.status == Status::ok);
      const auto& end = truth.values.back().bodies;
      CHECK(number(fabsq(end[0].v_m_per_s[0] + Wide(approach))) < 1e-32 * approach);
      CHECK(number(fabsq(end[1].v_m_per_s[0])) < 1e-32);
      CHECK(number(fabsq(end[1].v_m_per_s[1] - 1)) < 1e-32);
    }
}
