// CVODE's bars against closed forms: they must cover the true error, and not by being absurd.
#include <catch2/catch.hpp>

#include "../closed_form/scenes.hpp"
#include "cvode/cvode.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

struct Compared {
  double worst_error = 0;  // over positions, velocities, attitude, body rates, of all samples
  double worst_ratio = 0;  // of an error to its bar
  double widest_bar = 0;
};

template <std::size_t N>
void compare(Compared& into, const std::array<Wide, N>& a, const std::array<Wide, N>& b,
             const std::array<Wide, N>& bar) {
  for (std::size_t i = 0; i < N; ++i) {
    const double error = static_cast<double>(fabsq(a[i] - b[i])), half_width = static_cast<double>(bar[i]);
    into.worst_error = std::fmax(into.worst_error, error);
    into.widest_bar = std::fmax(into.widest_bar, half_width);
    if (error > 0) into.worst_ratio = std::fmax(into.worst_ratio, error / half_width);
  }
}

Compared compare(const Truth& tested, const Truth& exact) {
  INFO(tested.outcome.reason << exact.outcome.reason);
  REQUIRE(tested.outcome.status == Status::ok);
  REQUIRE(exact.outcome.status == Status::ok);
  REQUIRE(tested.values.size() == exact.values.size());
  Compared made;
  for (std::size_t k = 1; k < tested.values.size(); ++k)
    for (std::size_t i = 0; i < tested.values[k].bodies.size(); ++i) {
      const BodySample &a = tested.values[k].bodies[i], &b = exact.values[k].bodies[i], &bar = tested.bars[k].bodies[i];
      compare(made, a.p_m, b.p_m, bar.p_m);
      compare(made, a.v_m_per_s, b.v_m_per_s, bar.v_m_per_s);
      compare(made, a.q_wxyz, b.q_wxyz, bar.q_wxyz);
      compare(made, a.w_rad_per_s, b.w_rad_per_s, bar.w_rad_per_s);
    }
  return made;
}

Scenario bouncing(double e, double t_end_s) {
  Scenario given = scenario("bounce", t_end_s);
  given.scene.gravity_m_per_s2 = {0, 0, -9.81};
  given.scene.pairs[0].restitution = e;
  given.scene.bodies = {ball("ball", 0.5, 0.1, {0, 0, 1.1}, {0.3, 0, 0}), point("ground", 0, {0, 0, 0}, {0, 0, 0})};
  given.scene.bodies[1].shape = Plane{{0, 0, 1}, 0};
  given.scene.bodies[1].fixed = true;
  return given;
}

}  // namespace

TEST_CASE("Kepler e = 0.6 to t = 50: the bar covers the error, which is as large as is known of CVODE") {
  Scenario given = scenario("kepler", 50);
  given.scene.bodies = {point("planet", 1, {0.4, 0, 0}, {0, 2, 0})};
  given.scene.forces = {Attractor{{0}, {0, 0, 0}, 1}};
  const Compared made = compare(cvode_truth(given, 50), closed_form_truth(given, 50));
  CHECK(made.worst_ratio < 1);
  CHECK(made.worst_error < 1e-6);  // the largest over the run, not only at the end
  const BodySample end = cvode_truth(given, 50).values.back().bodies[0];
  const BodySample exact = closed_form_truth(given, 50).values.back().bodies[0];
  double at_end = 0;
  for (int k = 0; k < 3; ++k) {
    at_end = std::fmax(at_end, static_cast<double>(fabsq(end.p_m[k] - exact.p_m[k])));
    at_end = std::fmax(at_end, static_cast<double>(fabsq(end.v_m_per_s[k] - exact.v_m_per_s[k])));
  }
  INFO("largest component at t = 50: " << at_end << ", largest over the run: " << made.worst_error);
  CHECK(at_end > 4.1e-8 / 5);  // measured elsewhere: 4.1e-8
  CHECK(at_end < 4.1e-8 * 5);
  CHECK(made.widest_bar < 1e-3);
}

TEST_CASE("A damped driven oscillator, a tumbling box, a thruster with switches") {
  Scenario swing = scenario("oscillator", 20);
  swing.scene.bodies = {point("bob", 2, {1, 0, 0}, {-0.5, 0, 0})};
  swing.scene.forces = {Spring{{0}, {0, 0, 0}, 8, 0.3, 0, {}}, Drive{{0}, {3, 0, 0}, 1.7, 0.4}};
  const Compared oscillator = compare(cvode_truth(swing, 64), closed_form_truth(swing, 64));
  CHECK(oscillator.worst_ratio < 1);
  CHECK(oscillator.worst_error < 1e-9);

  Scenario box = scenario("free-rigid-body", 10);
  box.scene.bodies = {solid("box", 10, {0.8083333333333333, 0.6833333333333333, 0.1416666666666667}, {0.1, 5, 0.1})};
  const Compared tumbling = compare(cvode_truth(box, 64), closed_form_truth(box, 64));
  CHECK(tumbling.worst_ratio < 1);
  CHECK(tumbling.worst_error < 1e-7);

  Scenario ship = scenario("axis-torque", 4);
  ship.scene.bodies = {solid("ship", 5, {2, 3, 4}, {0, 0, 0.5})};
  ship.scene.forces = {Thruster{0, {1, 0, 0}, {0, 1, 0}, 6, {{0, 1}, {2.5, 3}}}};
  const Compared thrusting = compare(cvode_truth(ship, 64), closed_form_truth(ship, 64));
  CHECK(thrusting.worst_ratio < 1);
  CHECK(thrusting.worst_error < 1e-9);  // without restarts at the switches it is 1e-6 and more
}

TEST_CASE("A bouncing ball: impacts at roots, restitution, the end of the bounces") {
  for (const double e : {0.0, 0.5, 0.8, 1.0}) {
    Scenario given = bouncing(e, 5);  // 0.8 stops at sqrt(2/9.81) 1.8/0.2 = 4.06 s
    const Truth tested = cvode_truth(given, 64), exact = closed_form_truth(given, 64);
    const Compared made = compare(tested, exact);
    CAPTURE(e, made.worst_error, made.worst_ratio);
    CHECK(made.worst_ratio < 1);
    CHECK(made.worst_error < 1e-6);
    REQUIRE(tested.events.size() >= (e == 1.0 ? 5 : 2));
    for (std::size_t k = 0; k + 1 < tested.events.size() && k + 1 < exact.events.size() && k < 20; ++k) {
      CHECK(tested.events[k].kind == exact.events[k].kind);
      CHECK(static_cast<double>(fabsq(tested.events[k].t_s - exact.events[k].t_s)) <= tested.event_bar_s[k]);
      // An error of 1e-12 in height is one of g 1e-12 / v in the speed of a bounce.
      const double v = static_cast<double>(fabsq(exact.events[k].vn_before_m_per_s));
      const double allowed = v > 0 ? 10 * 0.5 * (1 + e) * (9.81 * 1e-12 / v + 1e-12 * v) : 1e-15;
      CHECK(static_cast<double>(fabsq(tested.events[k].impulse_n_N_s - exact.events[k].impulse_n_N_s)) < allowed);
    }
    if (e == 1.0) continue;
    CHECK(tested.events.back().kind == EventKind::rest);
    CHECK(static_cast<double>(fabsq(tested.events.back().t_s - exact.events.back().t_s)) < 1e-6);
  }
}

TEST_CASE("Two balls collide; so do two so small that a step jumps over the impact") {
  for (const auto& [speed, size] : {std::pair{1.0, 1.0}, std::pair{1000.0, 1.0}, std::pair{1.0, 1e-4}}) {
    // Between two samples: CVODE evaluates its root functions at samples too.
    Scenario given = scenario("sphere-impact", 4 / speed);
    given.scene.pairs[0].restitution = 0.7;
    given.scene.bodies = {ball("a", 1, 0.1 * size, {0, 0.05 * size, 0}, {0, 0, 0}),
                          ball("b", 2, 0.15 * size, {2.03, 0, 0}, {-speed, 0, 0})};
    const Truth tested = cvode_truth(given, 64), exact = closed_form_truth(given, 64);
    const Compared made = compare(tested, exact);
    CAPTURE(speed, size, made.worst_error);
    CHECK(made.worst_ratio < 1);
    CHECK(made.worst_error < 1e-9 * speed / size);
    REQUIRE(tested.events.size() == 1);
    CHECK(static_cast<double>(fabsq(tested.events[0].t_s - exact.events[0].t_s)) < 1e-10);
  }
}

TEST_CASE("Two rough balls with spin, slipping or sticking") {
  for (const double mu : {0.02, 5.0}) {
    Scenario given = scenario("sphere-impact", 2);
    given.scene.pairs[0] = {0, 0, 0.9, mu, 0};
    given.scene.bodies = {ball("a", 1, 0.125, {-1, 0, 0}, {3, 0, 0}), ball("b", 2, 0.125, {1, 0.1, 0}, {-1, 0.2, 0.1})};
    given.scene.bodies[0].angular_velocity_body_rad_per_s = {2, -5, 20};
    const Truth tested = cvode_truth(given, 64), exact = closed_form_truth(given, 64);
    const Compared made = compare(tested, exact);
    CAPTURE(mu, made.worst_error);
    CHECK(made.worst_ratio < 1);
    CHECK(made.worst_error < 1e-8);
    REQUIRE(tested.events.size() == 1);
    CHECK(static_cast<double>(tested.events[0].impulse_t_N_s) ==
          Approx(static_cast<double>(exact.events[0].impulse_t_N_s)).epsilon(1e-8));
  }
}

// After an impact without rebound the gap is round-off, and so is its rate: below zero as often as above. With friction
// and spin the balls roll off each other; head-on they stay together, falling or slowed down alike.
TEST_CASE("Balls without rebound collide once, for every rounding of their gap") {
  Scenario given = scenario("sphere-impact", 2);
  given.scene.pairs[0] = {0, 0, 0, 0.3, 0};
  given.scene.bodies = {ball("a", 1, 0.125, {-1, 0, 0}, {3, 0, 0}), ball("b", 2, 0.125, {1, 0.1, 0}, {-1, 0.2, 0.1})};
  given.scene.bodies[0].angular_velocity_body_rad_per_s = {5, -10, 20};
  for (const double z : {0.0, 0.01, 0.02, 0.03, 0.04}) {
    given.scene.bodies[1].position_m[2] = z;
    const Truth tested = cvode_truth(given, 64), exact = closed_form_truth(given, 64);
    const Compared made = compare(tested, exact);
    CAPTURE(z, made.worst_error);
    CHECK(made.worst_ratio < 1);
    CHECK(made.worst_error < 1e-8);
    CHECK(tested.events.size() == 1);
  }

  given = scenario("sphere-impact", 4);
  given.scene.bodies = {ball("a", 1, 0.125, {-1, 0, 0}, {3.1, 0.3, 0}), ball("b", 1, 0.125, {1, 0, 0}, {-1, 0.3, 0})};
  for (const bool falls : {false, true}) {
    given.scene.gravity_m_per_s2 = {0.3, -1, falls ? -9.81 : 0};
    given.scene.forces.clear();
    if (!falls) given.scene.forces = {LinearDrag{{0, 1}, 0.7, {0, 0, 0}, 0}};
    const Truth tested = cvode_truth(given, 64);
    INFO(tested.outcome.reason);
    REQUIRE(tested.outcome.status == Status::ok);
    CHECK(tested.events.size() == 1);
    const SampleView& end = tested.values.back();
    CHECK(std::fabs(static_cast<double>(end.bodies[1].p_m[0] - end.bodies[0].p_m[0]) - 0.25) < 1e-11);
  }
}

// A root of the gap would not show it: the gap is round-off when the push sets in.
TEST_CASE("Balls that touch and are pressed on each other by a force that rises from nothing are refused") {
  Scenario given = scenario("pressed", 4);
  given.scene.bodies = {ball("a", 1, 0.125, {0, 0, 0}, {0, 1, 0}), ball("b", 1, 0.125, {0.25, 0, 0}, {0, 1, 0})};
  given.scene.forces = {Drive{{0}, {1, 0, 0}, 1, -1.5707963267948966}, Drive{{0, 1}, {1, 0, 0}, 0, 0}};
  const Truth pressed = cvode_truth(given, 64);
  CHECK(pressed.outcome.status == Status::unsupported);
  CHECK(pressed.outcome.reason.find("`a` comes to rest on `b`, which is not a plane: not covered") !=
        std::string::npos);
  std::get<Drive>(given.scene.forces[0]).force_N = {-1, 0, 0};  // away from each other
  const Truth parted = cvode_truth(given, 64);
  CHECK(parted.outcome.reason == "");
  // x_a - t^2 / 2 = -(t - sin t)
  CHECK(static_cast<double>(parted.values.back().bodies[0].p_m[0]) == Approx(8 - (4 - std::sin(4.0))).epsilon(1e-9));
}

TEST_CASE("A ball that lies on its plane rests there, whatever its restitution") {
  Scenario given = bouncing(1, 2);
  given.scene.bodies[0].position_m = {0, 0, 0.1};
  const Truth tested = cvode_truth(given, 64);
  REQUIRE(tested.outcome.reason == "");
  CHECK(static_cast<double>(tested.values.back().bodies[0].p_m[2]) == 0.1);
}

// A linear contact by the damped oscillator, Hertz's by quadrature: the closed form is other code in other arithmetic.
TEST_CASE("Compliant contacts: roots at touch and release") {
  for (const int kind : {0, 1, 2}) {
    Scenario given = scenario("penalty", 0.5);
    given.scene.bodies = {ball("left", 1, 0.125, {-0.25, 0, 0}, {1, 0, 0}),
                          ball("right", 3, 0.25, {0.19, 0, 0}, {-0.5, 0, 0})};
    PairLaw& law = given.scene.pairs[0];
    law.contact_law = kind == 2 ? ContactLaw::hertz : ContactLaw::linear;
    law.stiffness_N_per_m = 4000;
    law.damping_N_s_per_m = 20;
    law.pull = kind == 1;
    law.modulus_Pa = 5e5;
    const Truth tested = cvode_truth(given, 64), exact = closed_form_truth(given, 64);
    const Compared made = compare(tested, exact);
    CAPTURE(kind, made.worst_error, made.worst_ratio);
    CHECK(made.worst_ratio < 1);
    CHECK(made.worst_error < 1e-8);
  }
}

TEST_CASE(
    "A heavy ball on a soft floor: it bounces, the dashpot's force is spent and comes again, and it sinks to k d = m "
    "g") {
  Scenario given = bouncing(0, 6);
  PairLaw& law = given.scene.pairs[0];
  law.contact_law = ContactLaw::linear;
  law.stiffness_N_per_m = 200;
  law.damping_N_s_per_m = 6;
  const Truth truth = cvode_truth(given, 64);
  REQUIRE(truth.outcome.reason == "");
  CHECK(static_cast<double>(truth.values.back().bodies[0].p_m[2]) == Approx(0.1 - 0.5 * 9.81 / 200).epsilon(1e-6));
  law.friction = 0.1;
  CHECK(cvode_truth(given, 64).outcome.reason.find("have a compliant contact law and friction") != std::string::npos);
}

TEST_CASE("A ball released late, and contacts that are not covered") {
  Scenario late = bouncing(0.5, 3);
  late.scene.bodies[0].release_s = 0.75;
  late.scene.bodies[0].velocity_m_per_s = {0, 0, 0};
  CHECK(compare(cvode_truth(late, 64), closed_form_truth(late, 64)).worst_ratio < 1);

  Scenario rough = bouncing(0.5, 3);  // it slides when it comes to rest
  rough.scene.pairs[0].friction = 1e-3;
  const Truth refused = cvode_truth(rough, 8);
  CHECK(refused.outcome.status == Status::unsupported);
  CHECK(refused.outcome.reason.find("friction") != std::string::npos);
  Scenario boxed = bouncing(0.5, 3);
  boxed.scene.bodies[0].shape = Box{{0.1, 0.1, 0.1}};
  CHECK(cvode_truth(boxed, 8).outcome.reason.find("box `ball`") != std::string::npos);
}

TEST_CASE(
    "An initial gap between round-off and the contact tolerance is refused: the bodies would be treated as in contact") {
  for (const double apart : {1e-11, 1e-12, 1e-13}) {
    Scenario near = bouncing(0.5, 0.25);
    Body& ball = near.scene.bodies[0];
    ball.velocity_m_per_s = {0, 0, 0};
    ball.position_m[2] = std::get<Sphere>(ball.shape).radius_m * (1 + apart);
    const Truth truth = cvode_truth(near, 8);
    CHECK(truth.outcome.status == Status::unsupported);
    CHECK(truth.outcome.reason.find("expected a contact (gap 0 to ") != std::string::npos);
    ball.position_m[2] = std::get<Sphere>(ball.shape).radius_m;
    CHECK(cvode_truth(near, 8).outcome.status == Status::ok);
  }
}

// In exact arithmetic of these doubles the impact comes 2e-17 s before the release, and the ball strikes a held one.
TEST_CASE("An impact within its bar of a release ends the truth by name") {
  Scenario given = scenario("release", 2);
  given.scene.pairs[0].restitution = 1;
  given.scene.bodies = {ball("a", 1, 0.1, {-1, 0, 0}, {2, 0, 0}), ball("b", 1, 0.1, {0, 0, 0}, {0, 0, 0})};
  given.scene.bodies[1].release_s = 0.4;
  for (const std::int64_t samples : {1, 4}) {
    const Truth tie = cvode_truth(given, samples);
    CHECK(tie.outcome.status == Status::unsupported);
    CHECK(tie.outcome.reason.find("the release of `b` and the impact of `a` and `b` at t = 0.4 s") !=
          std::string::npos);
  }
  given.scene.bodies[1].release_s = 0.3;  // before the impact
  const Truth after = cvode_truth(given, 4);
  REQUIRE(after.outcome.reason == "");
  CHECK(static_cast<double>(after.values.back().bodies[0].p_m[0]) == Approx(-0.2));
}
