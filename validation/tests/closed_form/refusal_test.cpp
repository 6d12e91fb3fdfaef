// Scenes that a solution does not cover are refused by name; bars grow with the conditioning of the motion.
#include <catch2/catch.hpp>

#include "scenes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

std::string why(const Scenario& given) {
  const Truth truth = closed_form_truth(given, 8);
  CHECK(truth.outcome.status == Status::unsupported);
  CHECK(truth.values.empty());
  return truth.outcome.reason;
}

bool names(const std::string& text, const std::string& part) {
  INFO(text);
  CHECK(text.find(part) != std::string::npos);
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("Scenes that are not covered are refused, and the refusal names the cause") {
  Scenario given = scenario("ballistic", 1);
  given.scene.bodies = {point("stone", 1, {0, 0, 1}, {1, 0, 0})};
  REQUIRE(closed_form_truth(given, 8).outcome.status == Status::ok);
  given.scene.forces = {LinearDrag{{0}, 0.1, {0, 0, 0}, 0}};
  CHECK(names(why(given), "`drag` on `stone`"));
  given.truth.solution = "no-such";
  CHECK(names(why(given), "ballistic, linear-drag"));
  given.truth.solution = "kepler";
  CHECK(names(why(given), "`drag`"));
  given.truth.solution = "vertical-quadratic-drag";
  given.scene.gravity_m_per_s2 = {0, 0, -9.8};
  given.scene.forces = {QuadraticDrag{{0}, 1.2, 0.5, 0.1, {0, 0, 0}, 0}};
  CHECK(names(why(given), "not parallel to gravity"));
  given.truth.solution = "oscillator";
  given.scene.forces = {Spring{{0}, {0, 0, 0}, 3, 0.5, 0, {}}};
  CHECK(names(why(given), "leaves its line"));
  given.truth.solution = "kepler";
  given.scene.gravity_m_per_s2 = {0, 0, 0};
  given.scene.bodies[0].velocity_m_per_s = {0, 0, 1};
  given.scene.forces = {Attractor{{0}, {0, 0, 0}, 1}};
  given.scene.bodies[0].position_m = {0, 0, 0};
  CHECK(names(why(given), "starts at the centre"));

  Scenario ship = scenario("axis-torque", 1);
  ship.scene.bodies = {solid("ship", 5, {2, 3, 4}, {0, 0.5, 0})};
  ship.scene.forces = {Thruster{0, {1, 0, 0}, {0, 1, 0}, 6, {}}};
  CHECK(names(why(ship), "not along its axis of spin"));

  Scenario two = scenario("free-rigid-body", 1);
  two.scene.bodies = {ball("a", 1, 0.1, {0, 0, 0}, {0, 0, 0}), ball("b", 1, 0.1, {1, 0, 0}, {0, 0, 0})};
  CHECK(names(why(two), "could touch"));
  two.truth.solution = "bounce";
  CHECK(names(why(two), "`b`"));
  two.truth.solution = "sphere-impact";
  two.scene.bodies[1].position_m[0] = 0.15;
  CHECK(names(why(two), "overlap"));
}

TEST_CASE("Friction of a bouncing ball is refused when it would act, and only then") {
  Scenario given = scenario("bounce", 2);
  given.scene.gravity_m_per_s2 = {0, 0, -9.8};
  given.scene.pairs[0].friction = 0.3;
  given.scene.bodies = {point("ground", 0, {0, 0, 0}, {0, 0, 0}), ball("a", 1, 0.125, {0, 0, 1}, {0, 0, 1})};
  given.scene.bodies[0].shape = Plane{{0, 0, 1}, 0};
  given.scene.bodies[0].fixed = true;
  given.scene.bodies[1].angular_velocity_body_rad_per_s = {0, 0, 5};
  CHECK(closed_form_truth(given, 8).outcome.reason == "");
  given.scene.bodies[1].angular_velocity_body_rad_per_s = {0, 1, 0};
  CHECK(names(why(given), "friction"));
}

TEST_CASE("Bars grow with the conditioning of the motion") {
  Scenario given = scenario("kepler", 10);
  given.scene.bodies = {point("planet", 1, {0.4, 0, 0}, {0, 2, 0})};
  given.scene.forces = {Attractor{{0}, {0, 0, 0}, 1}};
  const double near = static_cast<double>(closed_form_truth(given, 16).bars.back().bodies[0].p_m[0]);
  given.t_end_s = 1e6;
  const double far = static_cast<double>(closed_form_truth(given, 16).bars.back().bodies[0].p_m[0]);
  CHECK(near > 0);
  CHECK(far > 1000 * near);
  CHECK(far < 1e-20);
  CHECK(closed_form_truth(given, 16).bars.front().bodies[0].p_m[0] == 0);
}
