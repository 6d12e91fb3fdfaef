// Pendulums, tops and joints with one coordinate: their samples satisfy Newton's and Euler's equations.
#include <catch2/catch.hpp>

#include "joint_scenes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

double worst(const Scenario& given, std::int64_t samples) {
  const Truth truth = closed_form_truth(given, samples);
  INFO(truth.outcome.reason);
  CHECK(truth.outcome.status == Status::ok);
  if (truth.outcome.status != Status::ok) return HUGE_VAL;
  Wide bar = 0;
  for (const SampleView sample : truth.bars)
    for (const BodySample& body : sample.bodies)
      for (int k = 0; k < 3; ++k) bar = fmaxq(bar, fmaxq(body.p_m[k], fmaxq(body.v_m_per_s[k], body.w_rad_per_s[k])));
  CHECK(static_cast<double>(bar) > 0);
  CHECK(static_cast<double>(bar) < 1e-22);
  const Deviations found = deviations(given, truth);
  INFO("velocity " << found.velocity << ", attitude " << found.attitude << ", force " << found.force << ", torque "
                   << found.torque << ", gap " << found.gap << ", rate " << found.rate);
  CHECK(found.worst() < 1e-18);
  return found.worst();
}

Body bar(double mass_kg) { return solid("bar", mass_kg, {0.5, 0.75, 0.125}, {0, 0, 0}); }

Scenario swing(double angle, double rate, double t_end_s = 2) {
  return mechanism(
      "pendulum", t_end_s, {bar(1.5)},
      {with_start(joint("pin", JointKind::hinge, -1, 0, {1, 2, 3}, {0, 0, 0.75}, {0, 1, 0}), angle, rate)});
}

}  // namespace

TEST_CASE("Pendulums swing, turn, and stay between on the separatrix") {
  CHECK(worst(swing(0.5, 0), 2048) < 1e-18);
  CHECK(worst(swing(-0.5, 3), 2048) < 1e-18);
  CHECK(worst(swing(3.12, 0), 2048) < 1e-18);
  CHECK(worst(swing(-3, 9), 4096) < 1e-18);
  CHECK(worst(swing(2, -9), 4096) < 1e-18);
  CHECK(worst(swing(7, -1), 2048) < 1e-18);
  // k = 1 exactly: J = 0.75 + 1.5 / 16 + ..., with w^2 = m g d / J = 16 and theta' = 2 w at the lowest place.
  Scenario border = mechanism(
      "pendulum", 2, {solid("bob", 1, {0.5, 0.375, 0.5}, {0, 0, 0})},
      {with_start(joint("pin", JointKind::hinge, -1, 0, {0, 0, 0}, {0, 0, 0.5}, {0, 1, 0}), 0, 8)}, {0, 0, -20});
  CHECK(worst(border, 4096) < 1e-18);
  const Truth truth = closed_form_truth(border, 64);  // theta = 2 gd(4 t): gd(x) = 2 atan tanh(x / 2)
  for (const SampleView sample : truth.values)
    CHECK(static_cast<double>(fabsq(sample.joints[0].q[0] - 4 * atanq(tanhq(2 * sample.t_s)))) < 1e-31);
}

TEST_CASE("The hinge may be oblique to gravity and to the principal axes, and its parent a fixed body") {
  Body skew = solid("skew", 2, {1, 1.5, 2}, {0, 0, 0});
  skew.inertia_kg_m2 = {1, 0.2, -0.1, 0.2, 1.5, 0.3, -0.1, 0.3, 2};
  Body wall = point("wall", 0, {0.5, -1, 2}, {0, 0, 0});
  wall.fixed = true;
  wall.orientation_wxyz = {0.5, 0.5, -0.5, 0.5};
  Joint pin = with_start(joint("pin", JointKind::hinge, 1, 0, {0.25, 0, 1}, {0.5, 0.25, -0.75}, {0.6, 0, 0.8}), 1, 2);
  pin.frame_wxyz = {0.8, 0, 0.6, 0};
  CHECK(worst(mechanism("pendulum", 3, {skew, wall}, {pin}, {1, -3, -9}), 2048) < 1e-18);
}

TEST_CASE("A pendulum of 10 s hits the figures of an integral: the period at 90 degrees") {
  // Point mass at 1 m from the horizontal: T = 4 sqrt(l / g) K(sin 45 deg), K = Gamma(1/4)^2 / (4 sqrt(pi)).
  Scenario given = mechanism(
      "pendulum", 1, {solid("bob", 0.5, {0.25, 0.25, 0.25}, {0, 0, 0})},
      {with_start(joint("pin", JointKind::hinge, -1, 0, {0, 0, 0}, {0, 0.5, 0}, {0, 0, 1}), 0, 0)}, {0, -10, 0});
  // J = 0.25 + 0.5 * 0.25 = 0.375, m g d / J = 2.5 / 0.375 = 20/3; from the horizontal.
  given.scene.joints[0].anchors_body_m[1] = {0.5, 0, 0};
  const Wide gamma = tgammaq(Wide(1) / 4), period = sqrtq(Wide(3) / 20) * gamma * gamma / sqrtq(acosq(-1));
  given.t_end_s = static_cast<double>(period);
  const Truth truth = closed_form_truth(given, 4);
  REQUIRE(truth.outcome.status == Status::ok);
  const Wide late = Wide(given.t_end_s) - period;  // near the return theta = theta0 - sign (20/3) late^2 / 2
  CHECK(static_cast<double>(fabsq(truth.values[4].joints[0].q[0] - (Wide(20) / 3) * late * late / 2)) < 1e-30);
}

TEST_CASE(
    "Tops: spherical and conical pendulums, cusp, loop, wave, fast, sleeping on both sides, through the vertical") {
  const auto top = [](Real3 moments, double mass, double length, double tilt, Real3 w, double g = 9.81) {
    Scenario given = mechanism("heavy-top", 1, {solid("top", mass, moments, {0, 0, 0})},
                               {joint("tip", JointKind::ball, -1, 0, {0, 0, 0}, {0, 0, -length})}, {0, 0, -g});
    given.scene.joints[0].coordinates = {std::cos(tilt / 2), 0, std::sin(tilt / 2), 0};
    given.scene.joints[0].rates = w;
    return given;
  };
  const Real3 slim{0.275, 0.275, 0.1};
  CHECK(worst(top(slim, 1, 0.5, 0.5, {0, 0, 30}), 2048) < 1e-18);     // cusp
  CHECK(worst(top(slim, 1, 0.5, 0.5, {0.4, -1, 30}), 2048) < 1e-18);  // loop
  CHECK(worst(top(slim, 1, 0.5, 0.5, {0.4, 1, 30}), 2048) < 1e-18);   // wave
  CHECK(worst(top(slim, 1, 0.5, 0.5, {0.4, 1, -30}), 2048) < 1e-18);
  CHECK(worst(top(slim, 1, 0.5, 2.5, {0.4, 1, 0}), 1024) < 1e-18);      // spherical pendulum
  CHECK(worst(top(slim, 1, 0.5, 2.5, {0, 1, 0}), 1024) < 1e-18);        // in a plane
  CHECK(worst(top(slim, 1, 0.5, 2.5, {1e-9, 1, 0}), 2048) < 1e-16);     // nearly
  CHECK(worst(top(slim, 1, 0.5, 3.0, {0.5, 12, 0.25}), 2048) < 1e-18);  // over the top
  CHECK(worst(top(slim, 1, 0.5, 1e-3, {0, 0, 50}), 2048) < 1e-18);      // sleeping
  CHECK(worst(top(slim, 1, 0.5, 1e-3, {0, 0, 20}), 2048) < 1e-18);      // falls
  CHECK(worst(top(slim, 1, 0.5, 0, {1, 0, 20}), 2048) < 1e-18);         // from the vertical
  CHECK(worst(top(slim, 1, 0.5, 0, {0, 0, 20}), 2048) < 1e-18);
  CHECK(worst(top({0.234375, 0.234375, 0.46875}, 15, 1, M_PI / 2, {-4.61538, 0, 150}), 8192) < 1e-16);
  // Conical: w across = W sin(tilt), spin = W cos(tilt), W^2 (I1 - I3) cos(tilt) = m g l with the pivot above.
  CHECK(worst(top(slim, 1, 0.5, 2, {-4 * std::sin(2.0), 0, 4 * std::cos(2.0)}), 1024) < 1e-18);
  Scenario hanging = top(slim, 1, 0.5, 0, {1, 0, 2});
  hanging.scene.gravity_m_per_s2 = {0, 0, 9.81};
  CHECK(worst(hanging, 1024) < 1e-18);
  hanging.scene.joints[0].rates = {0, 0, 2};
  CHECK(worst(hanging, 1024) < 1e-18);
}
