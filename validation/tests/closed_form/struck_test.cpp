// Impacts on rods: conserved quantities, and the impulse as a sum of a hundred thousand small ones. The pushed slab.
#include <algorithm>
#include <catch2/catch.hpp>

#include "scenes.hpp"
#include "validation/tests/catalogued.hpp"
#include "vectors.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

// bat, ball; both unturned, so body axes are the world's
struct Struck {
  Vec3 v[2], w[2];
};

// The blow as many small ones at the same point, each with the friction that stops the feet, or all the cone has.
Struck sum_of_blows(const Scene& scene, const Event& hit, int blows) {
  const Vec3 n = narrow(hit.normal), x = narrow(hit.x_m);
  const PairLaw& law = pair_law(scene, 0, 1);
  Struck now{};
  Vec3 arm[2];
  for (int i = 0; i < 2; ++i) {
    now.v[i] = scene.bodies[i].velocity_m_per_s;
    arm[i] = plus(x, -1, plus(scene.bodies[i].position_m, static_cast<double>(hit.t_s), now.v[i]));
  }
  const auto give = [&](const Vec3& J) {
    for (int i = 0; i < 2; ++i) {
      const double side = i == 0 ? -1 : 1;
      now.v[i] = plus(now.v[i], side / scene.bodies[i].mass_kg, J);
      const Vec3 moment = times(arm[i], J);
      for (int k = 0; k < 3; ++k) now.w[i][k] += side * moment[k] / scene.bodies[i].inertia_kg_m2[4 * k];
    }
  };
  const auto feet = [&] {
    return plus(plus(now.v[1], 1, times(now.w[1], arm[1])), -1, plus(now.v[0], 1, times(now.w[0], arm[0])));
  };
  const auto mobility = [&](const Vec3& d) {
    double sum = 0;
    for (int i = 0; i < 2; ++i) {
      const Vec3 moment = times(arm[i], d);
      sum += 1 / scene.bodies[i].mass_kg;
      for (int k = 0; k < 3; ++k) sum += moment[k] * moment[k] / scene.bodies[i].inertia_kg_m2[4 * k];
    }
    return sum;
  };
  const double u_n = along(feet(), n), each = -u_n / mobility(n) / blows;
  for (int k = 0; k < 100 * blows && along(feet(), n) < -law.restitution * u_n; ++k) {
    give(plus({0, 0, 0}, each, n));
    const Vec3 u = feet(), sliding = plus(u, -along(u, n), n);
    const double speed = length(sliding);
    if (speed < 1e-15) continue;
    const Vec3 d = plus({0, 0, 0}, 1 / speed, sliding);
    give(plus({0, 0, 0}, -std::min(law.friction * each, speed / mobility(d)), d));
  }
  return now;
}

}  // namespace

TEST_CASE(
    "A struck rod: momenta stay, each body's angular momentum about the touch stays, feet part at e their approach") {
  struct Case {
    const char* id;
    double mu, v_z, z;
  };
  for (const Case& c : {Case{"struck-rod", 0, 0, 0.35},
                        {"struck-rod", 0, 1, -0.2},
                        {"struck-rod-box", 0, 0, 0.375},
                        {"struck-rod-rough", 0.25, 1.5, 0.05},
                        {"struck-rod-rough", 3, 1.5, 0.05},
                        {"struck-rod-rough", 0.25, 0, 0.3},
                        {"struck-rod-rough", 0.1, 3, -0.9},
                        {"struck-rod-rough", 0.4, -1.5, 0.82},
                        {"struck-rod-box", 0.2, 0.25, 0.1}}) {
    Scenario given = catalogued(c.id);
    given.t_end_s = 0.5;
    given.scene.pairs.clear();
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b) given.scene.pairs.push_back({a, b, 0.5, c.mu, 0});
    Body& ball = given.scene.bodies[1];
    ball.velocity_m_per_s[2] = c.v_z;
    ball.position_m[2] = c.z;
    const Truth truth = closed_form_truth(given, 60);
    INFO(c.id << " " << c.mu << ": " << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    REQUIRE(truth.events.size() == 1);
    const Event& hit = truth.events[0];
    const Struck near = sum_of_blows(given.scene, hit, 100000);
    const Vec3 x = narrow(hit.x_m), n = narrow(hit.normal);
    Vec3 momentum{}, feet{};
    for (int i = 0; i < 2; ++i) {
      const Body& body = given.scene.bodies[i];
      const Vec3 v = narrow(truth.values.back().bodies[i].v_m_per_s),
                 w = narrow(truth.values.back().bodies[i].w_rad_per_s);
      CHECK(length(plus(v, -1, near.v[i])) < 1e-3);
      CHECK(length(plus(w, -1, near.w[i])) < 3e-2);
      const Vec3 arm = plus(x, -1, plus(body.position_m, static_cast<double>(hit.t_s), body.velocity_m_per_s));
      const Vec3 change = plus(v, -1, body.velocity_m_per_s), moment = times(arm, change);
      for (int k = 0; k < 3; ++k)
        CHECK(body.inertia_kg_m2[4 * k] * w[k] == Approx(body.mass_kg * moment[k]).margin(1e-14));
      momentum = plus(momentum, body.mass_kg, change);
      feet = plus(feet, i == 0 ? -1 : 1, plus(v, 1, times(w, arm)));
      if (i == 1) {
        // The touch is on the ball's surface, in the direction of the normal.
        CHECK(length(plus(arm, std::get<Sphere>(body.shape).radius_m, n)) < 1e-14);
        if (c.mu == 0) CHECK(length(times(change, n)) < 1e-14);
        CHECK(length(times(change, n)) <= c.mu * along(change, n) + 1e-14);
      }
    }
    CHECK(length(momentum) < 1e-14);
    CHECK(along(feet, n) == Approx(-0.5 * static_cast<double>(hit.vn_before_m_per_s)).epsilon(1e-13));
  }
}

TEST_CASE("A rod struck out of its planes of symmetry, or that comes round to strike again, is refused") {
  Scenario given = catalogued("struck-rod-box");
  given.scene.bodies[1].position_m = {-1.5, 0.1, 0.375};
  CHECK_THAT(closed_form_truth(given, 60).outcome.reason, Catch::Contains("tumbles"));
  given = catalogued("struck-rod");
  given.scene.bodies[1].position_m[2] =
      0.387;  // the ball keeps up with the bat's centre, and its other end comes round
  given.scene.bodies[1].mass_kg = 0.3;
  for (int k = 0; k < 9; k += 4) given.scene.bodies[1].inertia_kg_m2[k] = 0.4 * 0.3 * 0.0375 * 0.0375;
  CHECK_THAT(closed_form_truth(given, 60).outcome.reason, Catch::Contains("hit the ball again"));
}

TEST_CASE(
    "The pushed slab: 0.7385 and 0.211 m/s^2 along the push; momentum, the balls' spin, and where it stands or slips") {
  for (const char* id : {"friction-cone-0", "friction-cone-60"}) {
    const Scenario given = catalogued(id);
    const Truth truth = closed_form_truth(given, 60);
    INFO(truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    const Vec3 push = std::get<PointForce>(given.scene.forces[0]).force_N, e = plus({0, 0, 0}, 1 / length(push), push);
    const SampleView& end = truth.values.back();
    const Vec3 slab = narrow(end.bodies[0].v_m_per_s), ball = narrow(end.bodies[1].v_m_per_s);
    CHECK(along(slab, e) / 4 == Approx(0.7385).epsilon(1e-12));
    CHECK(along(ball, e) / 4 == Approx(0.211).epsilon(1e-12));
    CHECK(length(times(slab, e)) < 1e-14);
    CHECK(length(times(ball, e)) < 1e-14);
    // Nothing but the push and the ground's friction acts from outside; no torque about a line on the deck acts on a
    // ball: m r v = -I w; and its foot goes with the deck.
    CHECK(10 * along(slab, e) + 25 * along(ball, e) == Approx((150 - 0.4 * 35 * 9.81) * 4).epsilon(1e-12));
    const Vec3 w = narrow(end.bodies[1].w_rad_per_s), foot = plus(ball, 1, times(w, {0, 0, -0.25}));
    // (the balls turn about one axis alone, which is the same in body axes)
    CHECK(length(plus(foot, -1, slab)) < 1e-13);
    CHECK(0.25 * along(ball, e) == Approx(0.4 * 0.25 * 0.25 * length(w)).epsilon(1e-12));
  }
  Scenario given = catalogued("friction-cone-0");
  std::get<PointForce>(given.scene.forces[0]).force_N = {137, 0, 0};  // below 0.4 35 9.81 = 137.34
  CHECK(closed_form_truth(given, 60).values.back().bodies[0].v_m_per_s == std::array<Wide, 3>{});
  // Smooth enough, the balls slip on the deck: a = mu g each.
  given = catalogued("friction-cone-0");
  for (PairLaw& law : given.scene.pairs)
    if (law.friction == 0.8) law.friction = 0.01;
  const Truth slips = closed_form_truth(given, 60);
  REQUIRE(slips.outcome.reason == "");
  CHECK(static_cast<double>(slips.values.back().bodies[1].v_m_per_s[0]) == Approx(4 * 0.01 * 9.81).epsilon(1e-13));
  CHECK(static_cast<double>(slips.values.back().bodies[0].v_m_per_s[0]) ==
        Approx(4 * (150 - 0.4 * 35 * 9.81 - 25 * 0.01 * 9.81) / 10).epsilon(1e-12));
  given.scene.bodies[3].position_m[1] = -2.2;  // one ball out of line turns the slab
  CHECK_THAT(closed_form_truth(given, 60).outcome.reason, Catch::Contains("rotated about the vertical"));
  given.t_end_s = 9;
  given.scene.bodies[3].position_m[1] = 0;
  CHECK_THAT(closed_form_truth(given, 60).outcome.reason, Catch::Contains("off `slab`"));
}
