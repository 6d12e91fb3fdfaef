// Bouncing and colliding spheres, against laws that the solutions do not use.
#include <catch2/catch.hpp>

#include "scenes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

Scenario bouncing(double e, double t_end_s, double height_m) {
  Scenario given = scenario("bounce", t_end_s);
  given.scene.gravity_m_per_s2 = {0, 0, -9.81};
  given.scene.pairs[0].restitution = e;
  given.scene.bodies = {point("ground", 0, {0, 0, 0}, {0, 0, 0}),
                        ball("ball", 0.5, 0.125, {0, 0, 0.125 + height_m}, {0, 0, 0})};
  given.scene.bodies[0].shape = Plane{{0, 0, 2}, 0};  // n . x = 0, whatever n's length
  given.scene.bodies[0].fixed = true;
  return given;
}

double apart(Wide a, Wide b) { return static_cast<double>(fabsq(a - b)); }

}  // namespace

TEST_CASE("A dropped ball: instants of impacts, heights e^(2k) h0, and the stop at sqrt(2 h0/g) (1 + e)/(1 - e)") {
  for (const double e : {0.5, 0.8}) {
    const double h0 = 0.75;
    const Wide fall = sqrtq(2 * Wide(h0) / Wide(9.81)), stop = fall * (1 + Wide(e)) / (1 - Wide(e));
    const Scenario given = bouncing(e, 5, h0);
    const Truth truth = closed_form_truth(given, 4096);
    REQUIRE(truth.outcome.reason == "");
    Wide impact = fall, power = 1;
    for (int k = 0; k < 8; ++k) {
      CHECK(apart(truth.events[k].t_s, impact) < 1e-31);
      CHECK(truth.event_bar_s[k] > 0);
      CHECK(truth.event_bar_s[k] < 1e-29);
      CHECK(apart(truth.events[k].vn_after_m_per_s, -Wide(e) * truth.events[k].vn_before_m_per_s) < 1e-31);
      CHECK(truth.events[k].normal[2] == 1);  // from the ground to the ball
      // Energy per mass at any sample of this flight is that of an apex at e^(2k) h0.
      power *= Wide(e);
      const Wide next = impact + 2 * fall * power;
      int seen = 0;
      for (const SampleView s : truth.values)
        if (s.t_s > impact && s.t_s < next) {
          const BodySample& b = s.bodies[1];
          const Wide apex = b.p_m[2] - Wide(0.125) + b.v_m_per_s[2] * b.v_m_per_s[2] / (2 * Wide(9.81));
          CHECK(apart(apex, power * power * Wide(h0)) < 1e-30);
          ++seen;
        }
      CHECK(seen > 0);
      impact = next;
    }
    CHECK(truth.events.back().kind == EventKind::rest);
    CHECK(apart(truth.events.back().t_s, stop) < 1e-29);
    CHECK(truth.values.back().bodies[1].p_m[2] == Wide(0.125));
    CHECK(truth.values.back().bodies[1].v_m_per_s[2] == 0);
  }
}

TEST_CASE("e = 0 rests at once, e = 1 never, a tilted plane lets the ball slide on") {
  const Truth dead = closed_form_truth(bouncing(0, 2, 0.5), 64);
  REQUIRE(dead.events.size() == 2);
  CHECK(dead.events[0].kind == EventKind::impact);
  CHECK(dead.events[1].kind == EventKind::rest);
  CHECK(dead.events[0].t_s == dead.events[1].t_s);
  const Truth forever = closed_form_truth(bouncing(1, 20, 0.5), 64);
  for (const Event& event : forever.events) CHECK(event.kind == EventKind::impact);
  CHECK(forever.events.size() == 31);                               // (20 / sqrt(2 0.5 / 9.81) + 1) / 2 = 31.8
  CHECK(closed_form_truth(bouncing(0.5, 2, 0), 8).events.empty());  // it lies there from the start

  Scenario tilted = bouncing(0.5, 4, 0);
  tilted.scene.bodies[0].shape = Plane{{0.6, 0, 0.8}, 0};
  tilted.scene.bodies[1].position_m = {0.6, 0, 0.8};
  const Truth slides = closed_form_truth(tilted, 64);
  REQUIRE(slides.outcome.reason == "");
  const BodySample& end = slides.values.back().bodies[1];
  // At rest against the plane: the centre is a radius from it, the speed along it is g sin(angle) t.
  CHECK(apart((Wide(0.6) * end.p_m[0] + Wide(0.8) * end.p_m[2]) / sqrtq(Wide(0.6) * 0.6 + Wide(0.8) * 0.8), 0.125) <
        1e-30);
  CHECK(static_cast<double>(sqrtq(end.v_m_per_s[0] * end.v_m_per_s[0] + end.v_m_per_s[2] * end.v_m_per_s[2])) ==
        Approx(9.81 * 0.6 * 4).epsilon(1e-14));
}

TEST_CASE("Two spheres, oblique, unequal: momentum is kept, restitution holds along the line of centres, spin stays") {
  Scenario given = scenario("sphere-impact", 4);
  given.scene.gravity_m_per_s2 = {0, 0, -9.81};
  given.scene.pairs[0].restitution = 0.7;
  given.scene.bodies = {ball("a", 1, 0.25, {0, 0.125, 0.1}, {0.5, 0, 0}),
                        ball("b", 3, 0.5, {3, 0, 0}, {-1, 0.0625, 0})};
  given.scene.bodies[0].angular_velocity_body_rad_per_s = {1, 2, 3};
  const Truth truth = closed_form_truth(given, 64);
  REQUIRE(truth.outcome.reason == "");
  REQUIRE(truth.events.size() == 1);
  const Event& hit = truth.events[0];
  // The gap closes at that very instant.
  Wide square = 0, u_n = 0, after_n = 0;
  const BodySample &a = truth.values.back().bodies[0], &b = truth.values.back().bodies[1];
  for (int k = 0; k < 3; ++k) {
    const Body &first = given.scene.bodies[0], &second = given.scene.bodies[1];
    const Wide u = Wide(second.velocity_m_per_s[k]) - Wide(first.velocity_m_per_s[k]);
    const Wide d = Wide(second.position_m[k]) - Wide(first.position_m[k]) + hit.t_s * u;
    square += d * d;
    u_n += u * hit.normal[k];
    after_n += (b.v_m_per_s[k] - a.v_m_per_s[k]) * hit.normal[k];
    const Wide before = Wide(first.velocity_m_per_s[k]) + 3 * Wide(second.velocity_m_per_s[k]);
    CHECK(apart(a.v_m_per_s[k] + 3 * b.v_m_per_s[k], before + 4 * 4 * Wide(given.scene.gravity_m_per_s2[k])) < 1e-30);
    CHECK(a.w_rad_per_s[k] == k + 1);
  }
  CHECK(apart(sqrtq(square), 0.75) < 1e-31);
  CHECK(apart(hit.vn_before_m_per_s, u_n) < 1e-31);
  CHECK(apart(after_n, -Wide(0.7) * u_n) < 1e-30);
  CHECK(apart(hit.vn_after_m_per_s, after_n) < 1e-30);
  given.scene.bodies[1].position_m[1] = 5;  // passes by
  CHECK(closed_form_truth(given, 64).events.empty());
}

TEST_CASE("Rough spheres: angular momentum is kept, friction opposes the sliding, on its cone or to its end") {
  for (const double mu : {0.01, 2.0}) {
    Scenario given = scenario("sphere-impact", 2);
    given.scene.pairs[0].restitution = 0.9;
    given.scene.pairs[0].friction = mu;
    given.scene.bodies = {ball("a", 1, 0.125, {-1, 0, 0}, {3, 0, 0}), ball("b", 2, 0.25, {1, 0.1, 0}, {-1, 0.2, 0.1})};
    given.scene.bodies[0].angular_velocity_body_rad_per_s = {1, -3, 8};
    given.scene.bodies[1].angular_velocity_body_rad_per_s = {0, 2, 4};
    given.scene.bodies[1].orientation_wxyz = {0.5, 0.5, -0.5, 0.5};
    const Truth truth = closed_form_truth(given, 64);
    REQUIRE(truth.outcome.reason == "");
    REQUIRE(truth.events.size() == 1);
    const Event& hit = truth.events[0];
    // Spin alone of one body, or all angular momentum about the origin: by cross products, body by body.
    const auto turning = [&](const SampleView& s, int body) {
      std::array<Wide, 3> L{};
      for (int i = 0; i < 2; ++i) {
        if (body >= 0 && i != body) continue;
        const BodySample& b = s.bodies[i];
        const Wide m = given.scene.bodies[i].mass_kg, I = given.scene.bodies[i].inertia_kg_m2[0];
        const Wide w = b.q_wxyz[0], x = b.q_wxyz[1], y = b.q_wxyz[2], z = b.q_wxyz[3];
        const Wide R[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                           2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                           2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
        for (int k = 0; k < 3; ++k) {
          const int l = (k + 1) % 3, n = (k + 2) % 3;
          if (body < 0) L[k] += m * (b.p_m[l] * b.v_m_per_s[n] - b.p_m[n] * b.v_m_per_s[l]);
          for (int j = 0; j < 3; ++j) L[k] += I * R[3 * k + j] * b.w_rad_per_s[j];
        }
      }
      return L;
    };
    const auto first = turning(truth.values.front(), -1), last = turning(truth.values.back(), -1);
    for (int k = 0; k < 3; ++k) CHECK(apart(first[k], last[k]) < 1e-31);
    // How the surfaces slide at the contact point, without the part along the normal.
    const auto slip = [&](const SampleView& s) {
      std::array<Wide, 3> made{};
      for (int k = 0; k < 3; ++k) made[k] = s.bodies[1].v_m_per_s[k] - s.bodies[0].v_m_per_s[k];
      for (int i = 0; i < 2; ++i) {
        const auto spin = turning(s, i);
        const Wide I = given.scene.bodies[i].inertia_kg_m2[0], r = i == 0 ? 0.125 : 0.25;
        for (int k = 0; k < 3; ++k) {
          const int l = (k + 1) % 3, n = (k + 2) % 3;
          made[k] -= r / I * (spin[l] * hit.normal[n] - spin[n] * hit.normal[l]);
        }
      }
      Wide along = 0;
      for (int k = 0; k < 3; ++k) along += made[k] * hit.normal[k];
      for (int k = 0; k < 3; ++k) made[k] -= along * hit.normal[k];
      return made;
    };
    const auto before = slip(truth.values.front()), after = slip(truth.values.back());
    Wide before2 = 0, after2 = 0, work = 0, tangential2 = 0;
    for (int k = 0; k < 3; ++k) {
      const Wide J = 2 * (truth.values.back().bodies[1].v_m_per_s[k] - truth.values.front().bodies[1].v_m_per_s[k]);
      const Wide T = J - hit.impulse_n_N_s * hit.normal[k];
      before2 += before[k] * before[k];
      after2 += after[k] * after[k];
      work += T * before[k];
      tangential2 += T * T;
    }
    CHECK(apart(sqrtq(tangential2), hit.impulse_t_N_s) < 1e-31);
    CHECK(apart(work, -sqrtq(before2) * hit.impulse_t_N_s) < 1e-30);  // straight against the sliding
    if (mu < 1) {
      CHECK(apart(hit.impulse_t_N_s, Wide(mu) * hit.impulse_n_N_s) < 1e-31);
      CHECK(static_cast<double>(sqrtq(after2)) > 0.01);
    } else {
      CHECK(hit.impulse_t_N_s < Wide(mu) * hit.impulse_n_N_s);
      CHECK(static_cast<double>(sqrtq(after2)) < 1e-30);
    }
  }
}
