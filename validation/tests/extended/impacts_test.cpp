// Located impacts, the end of bouncing, switches, and the refusals of the extended truth.
#include <quadmath.h>

#include <catch2/catch.hpp>

#include "closed_form/closed_form.hpp"
#include "extended/extended.hpp"
#include "scenes.hpp"

using namespace atwood;

namespace {

double size(Wide x) { return static_cast<double>(fabsq(x)); }

double largest_bar(const Truth& truth) {
  double largest = 0;
  for (const SampleView sample : truth.bars)
    for (const BodySample& body : sample.bodies)
      for (int k = 0; k < 3; ++k) largest = std::max({largest, size(body.p_m[k]), size(body.v_m_per_s[k])});
  return largest;
}

Scenario two_spheres(double restitution, double offset_m) {
  Scene scene = scenes::empty_scene();
  scene.pairs[0].restitution = restitution;
  scene.bodies = {scenes::point("a", 2, {0, 0, 0}, {1, 0, 0}), scenes::point("b", 3, {2, offset_m, 0}, {-1, 0, 0})};
  for (Body& body : scene.bodies) body.shape = Sphere{0.25};
  return scenes::scenario(scene, 4);
}

}  // namespace

TEST_CASE("bounces come at the times of the parabola, and end in one rest") {
  const double e = 0.8, clearance = 1;
  const Scenario scenario = scenes::bounce(e, clearance, false, 5);
  const Truth truth = extended_truth(scenario, 40);
  REQUIRE(truth.outcome.reason == "");
  const Wide g = 9.81, fall = sqrtq(2 * Wide(clearance) / g);  // 0.125 + 1 and its difference to 0.125 are exact
  Wide flight = fall, t = fall;
  for (int k = 0; k < 20; ++k) {
    REQUIRE(truth.events[k].kind == EventKind::impact);
    CHECK(size(truth.events[k].t_s - t) < 1e-24);
    CHECK(truth.event_bar_s[k] < 1e-20);
    flight = k == 0 ? 2 * fall * Wide(e) : flight * Wide(e);
    t += flight;
  }
  REQUIRE(truth.events.back().kind == EventKind::rest);
  CHECK(size(truth.events.back().t_s - fall * (1 + Wide(e)) / (1 - Wide(e))) < 1e-18);
  CHECK(size(truth.values.back().bodies[1].p_m[2] - Wide(0.125)) < 1e-18);
  CHECK(truth.values.back().bodies[1].v_m_per_s[2] == 0);
  CHECK(largest_bar(truth) < 1e-14);
  const Event& first = truth.events[0];
  CHECK(size(first.vn_before_m_per_s + g * fall) < 1e-20);
  CHECK(size(first.impulse_n_N_s - Wide(0.5) * (1 + Wide(e)) * g * fall) < 1e-20);
  CHECK(first.normal[2] == 1);  // from the ground (0) to the ball (1)
}

TEST_CASE("with quadratic drag the bars hold, though drag has a kink at each apex") {
  const Truth truth = extended_truth(scenes::bounce(0.8, 1, true, 5), 40);
  REQUIRE(truth.outcome.reason == "");
  CHECK(truth.note == "");
  CHECK(largest_bar(truth) < 1e-17);
  for (const double bar : truth.event_bar_s) CHECK(bar < 1e-17);
  // The first fall has a closed form: z = m/k ln cosh(t sqrt(g k / m)), k = rho C A / 2.
  const Wide k = Wide(1.2) * Wide(0.47) * Wide(0.05) / 2, m = 0.5, g = 9.81;
  const Wide t = acoshq(expq(k / m)) / sqrtq(g * k / m);
  CHECK(size(truth.events[0].t_s - t) < 1e-22);
  // Rising to the first apex at v1 = e v: the kink lies at t1 + atan(v1 sqrt(k / (m g))) sqrt(m / (g k)).
  const Wide v1 = truth.events[0].vn_after_m_per_s, apex = m / (2 * k) * logq(1 + k * v1 * v1 / (m * g));
  const Wide up = atanq(v1 * sqrtq(k / (m * g))) * sqrtq(m / (g * k)),
             down = acoshq(expq(apex * k / m)) / sqrtq(g * k / m);
  CHECK(size(truth.events[1].t_s - truth.events[0].t_s - up - down) < 1e-20);
}

TEST_CASE("inelastic: one impact, at rest at once") {
  const Truth truth = extended_truth(scenes::bounce(0, 1, false, 2), 8);
  REQUIRE(truth.events.size() == 2);
  CHECK(truth.events[1].kind == EventKind::rest);
  CHECK(truth.events[1].t_s == truth.events[0].t_s);
}

TEST_CASE("elastic: never at rest, energy kept") {
  const Truth truth = extended_truth(scenes::bounce(1, 0.5, false, 3), 8);
  for (const Event& event : truth.events) CHECK(event.kind == EventKind::impact);
  const BodySample& end = truth.values.back().bodies[1];
  const Wide energy = end.v_m_per_s[2] * end.v_m_per_s[2] / 2 + Wide(9.81) * (end.p_m[2] - Wide(0.125));
  CHECK(size(energy - Wide(9.81) / 2) < 1e-25);
}

TEST_CASE("a ball that lies on its plane rests there, whatever its restitution") {
  for (const double e : {0.0, 0.5, 1.0}) {
    const Truth truth = extended_truth(scenes::bounce(e, 0, false, 2), 8);
    REQUIRE(truth.outcome.reason == "");
    CHECK(truth.events.empty());
    CHECK(truth.values.back().bodies[1].p_m[2] == Wide(0.125));
  }
}

TEST_CASE("spheres collide inside one long free step") {
  SECTION("head-on: at t = 3/4; momentum shared") {
    const Truth truth = extended_truth(two_spheres(0.5, 0), 2);
    REQUIRE(truth.events.size() == 1);
    CHECK(size(truth.events[0].t_s - Wide(0.75)) < 1e-28);
    CHECK(size(truth.events[0].impulse_n_N_s - Wide(18) / 5) < 1e-28);  // 1.5 * 2 * 6/5
  }
  SECTION("oblique: the normal turns with the offset") {
    const Truth truth = extended_truth(two_spheres(1, 0.3), 2);
    REQUIRE(truth.events.size() == 1);
    CHECK(size(truth.events[0].t_s - Wide(0.8)) < 1e-16);  // 0.4^2 + 0.3^2 = 0.5^2; 0.3 is not a double
    CHECK(static_cast<double>(truth.events[0].normal[1]) == Approx(0.6));
  }
  SECTION("a near miss is a miss, a graze is a hit") {
    CHECK(extended_truth(two_spheres(1, 0.5001), 2).events.empty());
    CHECK(extended_truth(two_spheres(1, 0.4999), 2).events.size() == 1);
  }
}

TEST_CASE("balls that touch and approach at the start: the first sample is the scene itself, in every truth") {
  Scenario given = two_spheres(1, 0);
  given.scene.bodies[1].position_m = {0.5, 0, 0};
  for (const char* solution : {"", "sphere-impact", "ball-flights"}) {
    INFO("solution " << solution);
    given.truth.solution = solution;
    const Truth truth = *solution == 0 ? extended_truth(given, 2) : closed_form_truth(given, 2);
    REQUIRE(truth.events.size() == 1);
    CHECK(truth.events[0].t_s == 0);
    for (int i = 0; i < 2; ++i) {
      CHECK(static_cast<double>(truth.values[0].bodies[i].v_m_per_s[0]) == given.scene.bodies[i].velocity_m_per_s[0]);
      CHECK(static_cast<double>(truth.bars[0].bodies[i].v_m_per_s[0]) == 0);
    }
    CHECK(static_cast<double>(truth.values[1].bodies[0].v_m_per_s[0]) ==
          Approx(-1.4));  // 2 v_cm - v, v_cm = (2 - 3) / 5
  }
}

TEST_CASE("thrusters: restarts at switches leave no trace in the bars") {
  const Scenario scenario = scenes::thrusters();
  const Truth truth = extended_truth(scenario, 7);  // samples that miss every switch
  REQUIRE(truth.outcome.status == Status::ok);
  CHECK(largest_bar(truth) < 1e-20);
}

TEST_CASE("a body stays in place until its release") {
  Scenario scenario = scenes::bounce(1, 100, false, 2);
  scenario.scene.bodies[1].release_s = 1;
  const Truth truth = extended_truth(scenario, 4);
  CHECK(truth.values[2].bodies[1].p_m[2] == Wide(100.125));
  CHECK(size(truth.values[4].bodies[1].p_m[2] - (Wide(100.125) - Wide(9.81) / 2)) < 1e-28);
}

// The closed form of two rough spheres is another derivation in other code: each bar covers the difference.
TEST_CASE("rough spheres that slip or stick, with spin: the closed form lies within the bars") {
  for (const double mu : {0.02, 5.0}) {
    Scenario rough = two_spheres(0.9, 0.1);
    rough.truth = {TruthKind::closed_form, "sphere-impact", ""};
    rough.scene.pairs[0].friction = mu;
    for (Body& body : rough.scene.bodies) {
      const double I = 0.025 * body.mass_kg;
      body.inertia_kg_m2 = {I, 0, 0, 0, I, 0, 0, 0, I};
      body.angular_velocity_body_rad_per_s = {2, -5, body.mass_kg};
    }
    const Truth tested = extended_truth(rough, 8), exact = closed_form_truth(rough, 8);
    REQUIRE(tested.outcome.reason == "");
    REQUIRE(exact.outcome.reason == "");
    REQUIRE(tested.events.size() == 1);
    CHECK(tested.events[0].impulse_t_N_s > 0);
    CHECK(size(tested.events[0].impulse_t_N_s - exact.events[0].impulse_t_N_s) < 1e-28);
    for (std::size_t k = 1; k < tested.values.size(); ++k)
      for (std::size_t i = 0; i < 2; ++i) {
        const BodySample &a = tested.values[k].bodies[i], &b = exact.values[k].bodies[i];
        const BodySample &p = tested.bars[k].bodies[i], &q = exact.bars[k].bodies[i];
        for (int c = 0; c < 3; ++c) {
          CHECK(size(a.p_m[c] - b.p_m[c]) <= size(p.p_m[c] + q.p_m[c]));
          CHECK(size(a.v_m_per_s[c] - b.v_m_per_s[c]) <= size(p.v_m_per_s[c] + q.v_m_per_s[c]));
          CHECK(size(a.w_rad_per_s[c] - b.w_rad_per_s[c]) <= size(p.w_rad_per_s[c] + q.w_rad_per_s[c]));
        }
        for (int c = 0; c < 4; ++c) CHECK(size(a.q_wxyz[c] - b.q_wxyz[c]) <= size(p.q_wxyz[c] + q.q_wxyz[c]));
      }
    CHECK(largest_bar(tested) < 1e-24);
  }
}

// Thrown flat onto a plate and off it, over its edge to the ground: 1/2 g t^2 by hand for every flight.
TEST_CASE("a ball bounces off a plate and falls to the ground") {
  Scene scene = scenes::empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -10};
  scene.pairs[0].restitution = 0.5;
  scene.bodies = {scenes::point("ground", 0, {0, 0, 0}, {0, 0, 0}), scenes::point("plate", 0, {0, 0, 5}, {0, 0, 0}),
                  scenes::point("ball", 1, {0.2, 0, 6.5}, {1.5, 0, 0})};
  scene.bodies[0].shape = Plane{};
  scene.bodies[1].shape = Rectangle{{1, 1}};
  scene.bodies[0].fixed = scene.bodies[1].fixed = true;
  scene.bodies[2].shape = Sphere{0.25};
  const Truth truth = extended_truth(scenes::scenario(scene, 2), 8);
  REQUIRE(truth.outcome.reason == "");
  REQUIRE(truth.events.size() == 2);
  CHECK(truth.events[0].body_a == 1);
  CHECK(size(truth.events[0].t_s - Wide(0.5)) < 1e-28);  // 1.25 m
  CHECK(truth.events[1].body_a == 0);
  // Up at 2.5 m/s from 5.25 to 0.25: 5 t^2 - 2.5 t - 5 = 0.
  CHECK(size(truth.events[1].t_s - Wide(0.5) - (Wide(2.5) + sqrtq(Wide(106.25))) / 10) < 1e-28);
}

TEST_CASE("scenes that are not covered are refused with a reason") {
  Scenario rough = two_spheres(1, 0.3);
  rough.scene.pairs[0].friction = 0.2;
  rough.scene.bodies[0].inertia_kg_m2 = {0.1, 0, 0, 0, 0.2, 0, 0, 0, 0.2};
  const Truth truth = extended_truth(rough, 2);
  CHECK(truth.outcome.status == Status::unsupported);
  CHECK(truth.outcome.reason ==
        "friction on `a`, whose principal moments of inertia differ, is not covered by the extended truth");
  CHECK(truth.values.empty());

  Scenario slowed = scenes::bounce(0.5, 0.25, false, 3);  // a torque that no law of the truth's has
  slowed.scene.pairs[0].friction = 0.2;
  slowed.scene.pairs[0].rolling_friction_m = 0.002;
  CHECK(extended_truth(slowed, 2).outcome.status == Status::unsupported);
  CHECK(extended_truth(slowed, 2).outcome.reason.find("rolling friction") != std::string::npos);

  Scenario rolling = scenes::bounce(0.5, 0.25, false, 3);
  rolling.scene.pairs[0].friction = 0.2;
  rolling.scene.gravity_m_per_s2 = {1, 0, -10};
  CHECK(extended_truth(rolling, 2).outcome.reason.find("slides or accelerates along it") != std::string::npos);

  Scenario boxes = two_spheres(1, 0);
  boxes.scene.bodies[0].shape = Box{{1, 1, 1}};
  CHECK(extended_truth(boxes, 2).outcome.reason ==
        "contact of box `a` with sphere `b` is not covered by the extended truth");

  Scenario overlapping = two_spheres(1, 0);
  overlapping.scene.bodies[1].position_m = {0.25, 0, 0};
  CHECK(extended_truth(overlapping, 2).outcome.reason == "`a` and `b` overlap at the start");
}

TEST_CASE("the flow's condition: free flight grows as t, by hand") {
  // p = p0 + v t with |p| up to 2, |v| = 1 (scale of each): dp/dp0 = 1, dp/dv0 = t scaled by 1/2 -> 1 + 4 / 2... per
  // axis.
  Scene scene = scenes::empty_scene();
  scene.bodies.push_back(scenes::point("a", 1, {-2, 0, 0}, {1, 0, 0}));
  CHECK(flow_condition(scene, 4, 4) == Approx(3).epsilon(1e-4));
}
