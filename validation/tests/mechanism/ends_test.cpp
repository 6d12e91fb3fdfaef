// Truths end by name where the motion of a mechanism ends, with what is certified before; their conditions.
#include <catch2/catch.hpp>
#include <cmath>

#include "extended/mechanism_truth.hpp"
#include "scenes.hpp"

using namespace atwood;

namespace {

Scenario over_pulley(double t_end_s, double radius_m, const Real3& counterweight, const Real3& bob) {
  Scenario made = mechanism_scenario(t_end_s);
  made.scene.bodies = {point_mass("counterweight", 3, counterweight), point_mass("bob", 1, bob)};
  Rope rope;
  rope.name = "rope";
  rope.bodies = {0, 1};
  Pulley pulley;
  pulley.axis = {0, 1, 0};
  pulley.radius_m = radius_m;
  pulley.inertia_kg_m2 = radius_m > 0 ? 0.0625 : 0;
  rope.over = {pulley};
  made.scene.ropes = {rope};
  return made;
}

}  // namespace

// The counterweight draws the bob, which swings, up to the pulley. The tension grows without bound there, like the
// inverse square root of the time that is left.
TEST_CASE("a rope's end that reaches its pulley ends the truth, with certified samples before") {
  const Scenario scenario = over_pulley(1, 0.25, {-0.25, 0, -2}, {0.95, 0, -0.7});
  const Truth truth = mechanism_truth(scenario, 40);
  CHECK(truth.outcome.status == Status::unsupported);
  CHECK(truth.outcome.reason.find("rope `rope`: an end reaches its pulley at t = 0.55592") == 0);
  REQUIRE(truth.values.size() == 23);
  REQUIRE(truth.bars.size() == 23);
  const Wide bar = truth.bars.back().bodies[1].p_m[0];
  CHECK(static_cast<double>(bar) > 0);
  CHECK(static_cast<double>(bar) < 1e-15);
}

// Without a swing the bob falls up into the fixed point over which its rope runs: (M - m) g / (M + m) is its
// acceleration.
TEST_CASE("a rope's end that is drawn into a fixed point ends the truth") {
  const Scenario scenario = over_pulley(1, 0, {-1, 0, -2}, {0, 0, -0.7});
  const Truth truth = mechanism_truth(scenario, 40);
  CHECK(truth.outcome.status == Status::unsupported);
  INFO(truth.outcome.reason);
  REQUIRE(truth.outcome.reason.find("rope `rope`: an end reaches its pulley at t = ") == 0);
  // The counterweight's rope is not vertical: its motion is a pendulum's, and the time no closed form's.
  CHECK(truth.values.size() > 10);
  CHECK(truth.values.size() < 40);
}

// Thrown upwards outside the pulley, the bob unwinds its rope: past the tangent of the other part nothing is wound on
// it.
TEST_CASE("a rope that leaves its pulley ends the truth") {
  Scenario scenario = over_pulley(1, 0.25, {-0.25, 0, -0.5}, {0.25, 0, -0.7});
  scenario.scene.gravity_m_per_s2 = {0, 0, 0};
  scenario.scene.bodies[1].velocity_m_per_s = {6, 0, 0};
  scenario.scene.bodies[0].mass_kg = 200;
  scenario.scene.bodies[0].inertia_kg_m2 = {};
  const Truth truth = mechanism_truth(scenario, 40);
  CHECK(truth.outcome.status == Status::unsupported);
  INFO(truth.outcome.reason);
  CHECK(truth.outcome.reason.find("rope `rope` leaves its pulley at t = ") == 0);
  CHECK(truth.values.size() > 2);
}

// An inverted pendulum at 0.1 rad leaves as cosh(w t), w^2 = m g l / I = 9.81: perturbations of its angle grow at most
// so.
TEST_CASE("the condition of a mechanism's motion is the growth of perturbations of its start") {
  Scenario scenario = mechanism_scenario(1);
  scenario.scene.bodies = {solid("bob", 1, 0.75)};
  scenario.scene.joints = {hinge(-1, 0, {}, {0, 0, -0.5}, 1e-3, 0)};  // I about the pivot: 1; m g l = 4.905
  const Truth truth = mechanism_truth(scenario, 4);
  REQUIRE(truth.outcome.status == Status::ok);
  // Scales: 1 rad of angles, the largest rate of rates. dq/dq0 = cosh wt, du/dq0 = w sinh wt, u = 1e-3 w sinh wt.
  const double w = std::sqrt(4.905), grown = 1e3;  // of the rate: w sinh(w t) over its own size
  CHECK(truth.condition > 0.5 * grown);
  CHECK(truth.condition < 2 * (grown + std::cosh(w)));
}

// Two links of a double pendulum, of which the upper one has next to no mass: in maximal coordinates the rates lose as
// many digits as the ratio of the masses has, in double and in quad.
namespace {

Scenario with_light_link(double light_kg) {
  Scenario made = mechanism_scenario(2);
  made.scene.bodies = {solid("upper", light_kg, 0.1 * light_kg), solid("lower", 1, 0.1)};
  made.scene.joints = {hinge(-1, 0, {}, {0, 0, 0.5}, 1.2, 0), hinge(0, 1, {0, 0, -0.5}, {0, 0, 0.5}, -0.7, 0.4)};
  return made;
}

}  // namespace

TEST_CASE("the truth of a mechanism with a very light link") {
  for (const double light_kg : {1e-6, 1e-9, 1e-12}) {
    const Truth truth = mechanism_truth(with_light_link(light_kg), 4);
    INFO(light_kg << " kg: " << truth.outcome.reason << " " << truth.note);
    REQUIRE(truth.outcome.status == Status::ok);
    REQUIRE(truth.values.size() == 5);
    const auto bar = static_cast<double>(truth.bars.back().bodies[1].p_m[0]);
    INFO(bar);
    CHECK(bar > 0);
    CHECK(bar < 1e-21);
  }
  const Truth lost = mechanism_truth(with_light_link(1e-16), 4);
  CHECK(lost.outcome.status == Status::unsupported);
  INFO(lost.outcome.reason);
  CHECK(lost.outcome.reason.find("the bodies' masses differ by a factor of 1e+16, at which") == 0);
}
