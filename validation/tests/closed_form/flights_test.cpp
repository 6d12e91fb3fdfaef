// Balls that hit balls, planes, rectangles and boxes, against integration in small steps that finds overlaps one step
// late and strikes by the matrix of the contact point.
#include <algorithm>
#include <catch2/catch.hpp>

#include "scenes.hpp"
#include "validation/tests/catalogued.hpp"
#include "vectors.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

template <class Q> Vec3 turned(const Q& q, const Vec3& v) {
  const Vec3 u{double(q[1]), double(q[2]), double(q[3])};
  return plus(v, 2, times(u, plus(times(u, v), double(q[0]), v)));
}

struct Moving {
  Vec3 p, v, w_W;
};

// From the ball's centre to the nearest point of the other body.
Vec3 to_nearest(const Scene& scene, const std::vector<Moving>& now, int ball, int other) {
  const Body& body = scene.bodies[other];
  const Vec3& p = now[ball].p;
  if (const auto* plane = std::get_if<Plane>(&body.shape))
    return plus({0, 0, 0}, plane->offset_m - along(plane->normal, p), plane->normal);
  if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
    const Vec3 d = plus(now[other].p, -1, p);
    return plus(d, -sphere->radius_m / length(d), d);
  }
  Vec3 half{};
  if (const auto* rectangle = std::get_if<Rectangle>(&body.shape))
    half = {rectangle->half_extents_m[0], rectangle->half_extents_m[1], 0};
  if (const auto* box = std::get_if<Box>(&body.shape)) half = box->half_extents_m;
  const Real4 &q = body.orientation_wxyz, back{q[0], -q[1], -q[2], -q[3]};
  const Vec3 local = turned(back, plus(p, -1, body.position_m));
  Vec3 nearest;
  for (int k = 0; k < 3; ++k) nearest[k] = std::clamp(local[k], -half[k], half[k]);
  return turned(q, plus(nearest, -1, local));
}

// The impulse that turns the contact point's velocity u into its end: K J = u_end - u with K = sum of (1/m) 1 - [r]
// I^-1 [r], for balls K = (1/m) n n^T + (1/m + r^2/I) (1 - n n^T).
void strike(const Scene& scene, std::vector<Moving>& now, int a, int b, const Vec3& n) {
  Vec3 u{};
  double k_n = 0, k_t = 0;
  for (const auto& [i, side] : {std::pair{a, -1.0}, {b, 1.0}}) {
    if (scene.bodies[i].fixed) continue;
    const double r = std::get<Sphere>(scene.bodies[i].shape).radius_m, m = scene.bodies[i].mass_kg;
    u = plus(u, side, plus(now[i].v, 1, times(now[i].w_W, plus({0, 0, 0}, -side * r, n))));
    k_n += 1 / m;
    k_t += 1 / m + r * r / scene.bodies[i].inertia_kg_m2[0];
  }
  const PairLaw& law = pair_law(scene, a, b);
  const double u_n = along(u, n);
  if (!(u_n < -1e-12)) return;
  Vec3 J = plus({0, 0, 0}, -(1 + law.restitution) * u_n / k_n, n);
  const Vec3 stop = plus({0, 0, 0}, -1 / k_t, plus(u, -u_n, n));
  const double most = law.friction * length(J), needed = length(stop);
  if (needed > 1e-15) J = plus(J, std::min(1.0, most / needed), stop);
  for (const auto& [i, side] : {std::pair{a, -1.0}, {b, 1.0}}) {
    if (scene.bodies[i].fixed) continue;
    const double r = std::get<Sphere>(scene.bodies[i].shape).radius_m;
    now[i].v = plus(now[i].v, side / scene.bodies[i].mass_kg, J);
    now[i].w_W = plus(now[i].w_W, side / scene.bodies[i].inertia_kg_m2[0], times(plus({0, 0, 0}, -side * r, n), J));
  }
}

std::vector<Moving> march(const Scenario& given, int steps) {
  const Scene& scene = given.scene;
  std::vector<Moving> now;
  for (const Body& body : scene.bodies)
    now.push_back(
        {body.position_m, body.velocity_m_per_s, turned(body.orientation_wxyz, body.angular_velocity_body_rad_per_s)});
  const double h = given.t_end_s / steps;
  const int count = static_cast<int>(scene.bodies.size());
  for (int k = 0; k < steps; ++k) {
    for (int i = 0; i < count; ++i) {
      if (scene.bodies[i].fixed || (k + 0.5) * h < scene.bodies[i].release_s) continue;
      now[i].p = plus(plus(now[i].p, h, now[i].v), h * h / 2, scene.gravity_m_per_s2);
      now[i].v = plus(now[i].v, h, scene.gravity_m_per_s2);
    }
    for (int i = 0; i < count; ++i) {
      if (!std::holds_alternative<Sphere>(scene.bodies[i].shape)) continue;
      for (int j = 0; j < count; ++j) {
        if (j == i || (j < i && std::holds_alternative<Sphere>(scene.bodies[j].shape))) continue;
        const Vec3 d = to_nearest(scene, now, i, j);
        const double gap = length(d) - std::get<Sphere>(scene.bodies[i].shape).radius_m;
        if (gap < 0) strike(scene, now, i, j, plus({0, 0, 0}, 1 / length(d), d));
      }
    }
  }
  return now;
}

double kinetic(const Scene& scene, const SampleView& s) {
  double sum = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Vec3 v = narrow(s.bodies[i].v_m_per_s), w = narrow(s.bodies[i].w_rad_per_s);
    if (!scene.bodies[i].fixed)
      sum += scene.bodies[i].mass_kg * along(v, v) / 2 + scene.bodies[i].inertia_kg_m2[0] * along(w, w) / 2;
  }
  return sum;
}

}  // namespace

TEST_CASE("Flights agree with an integration in small steps: slopes, a thin wall, separated rows, rough spheres") {
  // The march strikes a step late, at each impact
  struct Case {
    const char* id;
    double tolerance;
    int impacts;
  };
  for (const Case& given_case : {Case{"slopes", 2e-3, 23},
                                 {"bullet-through-paper", 1e-3, 1},
                                 {"cradle-apart-1", 1e-4, 4},
                                 {"cradle-apart-2", 1e-4, 6},
                                 {"cradle-apart-3", 1e-4, 6},
                                 {"cradle-unequal-apart", 1e-4, 9},
                                 {"oblique-rough-spin", 1e-4, 1},
                                 {"oblique-rough-roll", 1e-4, 1},
                                 {"oblique-rough-graze", 1e-3, 1},
                                 {"oblique-rough-dead", 1e-4, 1}}) {
    Scenario given = catalogued(given_case.id);
    given.truth.solution = "ball-flights";
    const Truth truth = closed_form_truth(given, given.samples);
    INFO(given_case.id << ": " << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    CHECK(truth.events.size() == static_cast<std::size_t>(given_case.impacts));
    const std::vector<Moving> near = march(given, 300000);
    for (std::size_t i = 0; i < near.size(); ++i) {
      const BodySample& end = truth.values.back().bodies[i];
      INFO(given.scene.bodies[i].name);
      CHECK(length(plus(near[i].p, -1, narrow(end.p_m))) < given_case.tolerance);
      CHECK(length(plus(near[i].v, -1, narrow(end.v_m_per_s))) < 10 * given_case.tolerance);
      CHECK(length(plus(near[i].w_W, -1, turned(end.q_wxyz, narrow(end.w_rad_per_s)))) < 30 * given_case.tolerance);
    }
    for (const Event& e : truth.events) {
      CHECK(e.vn_before_m_per_s < 0);
      CHECK(static_cast<double>(e.vn_after_m_per_s / e.vn_before_m_per_s) ==
            Approx(-pair_law(given.scene, e.body_a, e.body_b).restitution).margin(1e-15));
      CHECK(static_cast<double>(e.impulse_t_N_s / e.impulse_n_N_s) <=
            pair_law(given.scene, e.body_a, e.body_b).friction * (1 + 1e-15));
    }
  }
}

TEST_CASE("Two balls: the walk over impacts and the one impact of `sphere-impact` agree to round-off") {
  for (const char* id :
       {"head-on", "oblique", "oblique-rough", "oblique-rough-stick", "oblique-rough-spin", "oblique-rough-graze"}) {
    Scenario given = catalogued(id);
    const Truth one = closed_form_truth(given, given.samples);
    given.truth.solution = "ball-flights";
    const Truth walk = closed_form_truth(given, given.samples);
    REQUIRE(walk.outcome.reason == "");
    for (std::size_t k = 0; k < one.values.size(); ++k)
      for (int i = 0; i < 2; ++i)
        for (int c = 0; c < 3; ++c) {
          const BodySample &a = one.values[k].bodies[i], &b = walk.values[k].bodies[i];
          CHECK(static_cast<double>(fabsq(a.p_m[c] - b.p_m[c])) < 1e-30);
          CHECK(static_cast<double>(fabsq(a.v_m_per_s[c] - b.v_m_per_s[c])) < 1e-30);
          CHECK(static_cast<double>(fabsq(a.w_rad_per_s[c] - b.w_rad_per_s[c])) < 1e-30);
          CHECK(static_cast<double>(fabsq(a.q_wxyz[c] - b.q_wxyz[c])) < 1e-30);
        }
  }
}

TEST_CASE("A ball that bounces on a plane: the walk agrees with the geometric series") {
  Scenario given = catalogued("bounce-e0.8");
  given.t_end_s = 3;
  const Truth series = closed_form_truth(given, 60);
  given.truth.solution = "ball-flights";
  const Truth walk = closed_form_truth(given, 60);
  REQUIRE(walk.outcome.reason == "");
  REQUIRE(walk.events.size() == series.events.size());
  for (std::size_t k = 0; k < walk.events.size(); ++k)
    CHECK(static_cast<double>(fabsq(walk.events[k].t_s - series.events[k].t_s)) < 1e-30);
  CHECK(static_cast<double>(fabsq(walk.values.back().bodies[0].p_m[2] - series.values.back().bodies[0].p_m[2])) <
        1e-29);
  given.t_end_s = 5;  // it comes to rest
  CHECK_THAT(closed_form_truth(given, 60).outcome.reason, Catch::Contains("rest"));
}

TEST_CASE("Cradles: as many balls leave as arrive; a ball of half the mass leaves at 4/3 of the speed") {
  for (const std::string kind : {"touching", "apart"})
    for (int k = 1; k <= 3; ++k) {
      const Truth truth = closed_form_truth(catalogued("cradle-" + kind + "-" + std::to_string(k)), 60);
      for (int i = 0; i < 5; ++i)
        CHECK(static_cast<double>(fabsq(truth.values.back().bodies[i].v_m_per_s[0] - Wide(i >= 5 - k))) < 1e-32);
    }
  const Truth truth = closed_form_truth(catalogued("cradle-unequal"), 60);
  REQUIRE(truth.events.size() == 4);
  Wide v = 1;
  for (int i = 0; i < 4; ++i, v = v * 4 / 3) {
    CHECK(truth.events[i].body_a == i);  // from neighbour to neighbour
    CHECK(static_cast<double>(fabsq(truth.values.back().bodies[i].v_m_per_s[0] - v / 3)) < 1e-32);
  }
  for (const char* id : {"cradle-unequal", "cradle-unequal-apart"}) {
    const Scenario given = catalogued(id);
    const Truth of = closed_form_truth(given, 60);
    CHECK(kinetic(given.scene, of.values.back()) == Approx(kinetic(given.scene, of.values.front())).epsilon(1e-15));
  }
}

TEST_CASE("The spin of the fifth ball of the slopes follows from its impulse; friction dissipates energy") {
  const Scenario given = catalogued("slopes");
  const Truth truth = closed_form_truth(given, given.samples);
  for (const Event& e : truth.events) {
    const Body& hit = given.scene.bodies[e.body_b];
    if (hit.name != "fifth") continue;
    for (const SampleView s : truth.values)
      if (s.t_s > e.t_s) {
        const Vec3 w = narrow(s.bodies[e.body_b].w_rad_per_s);
        CHECK(length(w) == Approx(static_cast<double>(e.impulse_t_N_s) * 0.2 / hit.inertia_kg_m2[0]).epsilon(1e-12));
        CHECK(length(w) > 15);
        break;
      }
    break;
  }
  double before = HUGE_VAL;
  for (const SampleView s : truth.values) {
    double energy = kinetic(given.scene, s);
    for (std::size_t i = 0; i < given.scene.bodies.size(); ++i)
      if (!given.scene.bodies[i].fixed)
        energy += given.scene.bodies[i].mass_kg * 9.81 * static_cast<double>(s.bodies[i].p_m[2]);
    CHECK(energy <= before * (1 + 1e-14));
    before = energy;
  }
}

TEST_CASE("Edges, held balls and shapes other than balls are refused by name") {
  const auto why = [](const Scenario& given) {
    const Truth truth = closed_form_truth(given, 60);
    CHECK(truth.outcome.status == Status::unsupported);
    return truth.outcome.reason;
  };
  Scenario given = catalogued("slopes");
  for (Body& body : given.scene.bodies)
    if (body.name == "fifth") body.position_m = {1.1, -3.3, 8};
  CHECK_THAT(why(given), Catch::Contains("`fifth` may hit an edge of `slope-south`"));
  given = catalogued("slopes");
  for (Body& body : given.scene.bodies)
    if (body.name == "second-east") {
      body.release_s = 2;
      body.position_m = {4, 0, 2.7};
    }
  CHECK_THAT(why(given), Catch::Contains("`second-east` before its release"));
  given = catalogued("bullet-through-paper");
  given.scene.bodies[0].position_m = {-1.53, 0.8995, 0};  // y at the wall: 1.0012, past the rim by less than its radius
  CHECK_THAT(why(given), Catch::Contains("edge of `paper`"));
  given.scene.bodies[0].position_m = {-1.53, 0.95, 0};  // past the wall
  CHECK(closed_form_truth(given, 60).events.empty());
  given.scene.bodies[0].shape = Box{{0.1, 0.1, 0.1}};
  CHECK_THAT(why(given), Catch::Contains("`bullet` is free and has another shape"));
}

TEST_CASE("A sample at the very instant of a rough impact has bars as wide as the jumps of velocity and spin") {
  Scenario given = catalogued("oblique-rough-spin");
  given.t_end_s = 1.75;  // the impact comes at 0.4375 s
  for (const char* solution : {"ball-flights", "sphere-impact"}) {
    given.truth.solution = solution;
    const Truth truth = closed_form_truth(given, 4);
    REQUIRE(truth.events.size() == 1);
    REQUIRE(truth.values[1].t_s == truth.events[0].t_s);
    CHECK(truth.note != "");
    for (int i = 0; i < 2; ++i)
      for (int c = 0; c < 3; ++c) {
        const BodySample &before = truth.values[0].bodies[i], &after = truth.values[1].bodies[i];
        const BodySample& bar = truth.bars[1].bodies[i];
        CHECK(bar.v_m_per_s[c] >= fabsq(after.v_m_per_s[c] - before.v_m_per_s[c]));
        CHECK(bar.w_rad_per_s[c] >= fabsq(after.w_rad_per_s[c] - before.w_rad_per_s[c]));
      }
    CHECK(static_cast<double>(truth.bars[2].bodies[0].v_m_per_s[0]) < 1e-28);
  }
}

// A ball between a wall and another that is 100^k times as heavy: the digits of pi (G. Galperin, Playing pool with pi,
// Regular and Chaotic Dynamics 8, 2003).
TEST_CASE("Galperin's billiard: the number of impacts has the digits of pi, without a limit on their count") {
  for (const auto& [power, kDigits] : {std::pair{3, 3141u}, std::pair{4, 31415u}}) {
    Scenario given = scenario("ball-flights", 6);
    given.scene.pairs[0].restitution = 1;
    given.scene.bodies = {point("wall", 0, {0, 0, 0}, {0, 0, 0}), ball("light", 1, 0.125, {1, 0, 0}, {0, 0, 0}),
                          ball("heavy", std::pow(100.0, power), 0.125, {2, 0, 0}, {-1, 0, 0})};
    given.scene.bodies[0].fixed = true;
    given.scene.bodies[0].shape = Plane{{1, 0, 0}, 0};
    const Truth truth = closed_form_truth(given, 12);
    INFO(truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    CHECK(truth.events.size() == kDigits);
    // Energy and momentum of the two, after the last impact: the heavy one's speed differs from 1 by 1e-2 / 100^k.
    CHECK(static_cast<double>(truth.values.back().bodies[2].v_m_per_s[0]) == Approx(1).epsilon(1e-4));
    // Directed roundings of long double add up over the impacts: 3e-23 m after 31 415 of them.
    CHECK(static_cast<double>(truth.bars.back().bodies[2].p_m[0]) < 1e-22);
  }
}
