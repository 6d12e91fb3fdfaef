// Boxes and round bodies on a floor, compared with an integration in small steps that assumes neither slip, roll nor
// straight lines.
#include <catch2/catch.hpp>

#include "scenes.hpp"
#include "validation/tests/catalogued.hpp"
#include "vectors.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

struct Moving {
  Vec3 p, v, w;
};

// Moreau's step: gravity, then the impulse in the cone that comes nearest to stopping the foot. First order in h.
Moving march(const Scene& scene, int at, const Vec3& n, double height, double t_end_s, int steps) {
  const Body& body = scene.bodies[at];
  const double h = t_end_s / steps, m = body.mass_kg;
  const double mu = pair_law(scene, at, static_cast<int>(scene.bodies.size()) - 1).friction;
  const bool turns = !std::holds_alternative<Box>(body.shape);
  const double inverse_I = turns ? 1 / body.inertia_kg_m2[8] : 0, mass = 1 / (1 / m + height * height * inverse_I);
  Moving now{body.position_m, body.velocity_m_per_s, {0, 0, 0}};
  if (turns) now.w = body.angular_velocity_body_rad_per_s;  // these start unturned, or without spin
  const Vec3 arm = plus({0, 0, 0}, -height, n);
  for (int k = 0; k < steps; ++k) {
    now.v = plus(now.v, h, scene.gravity_m_per_s2);
    const double push = -m * along(now.v, n);  // the floor's normal impulse
    now.v = plus(now.v, push / m, n);
    const Vec3 foot = plus(now.v, 1, times(now.w, arm));
    const double speed = std::sqrt(along(foot, foot));
    if (speed > 0) {
      const double rub = std::min(mu * push, mass * speed);
      const Vec3 impulse = plus({0, 0, 0}, -rub / speed, foot);
      now.v = plus(now.v, 1 / m, impulse);
      now.w = plus(now.w, inverse_I, times(arm, impulse));
    }
    now.p = plus(now.p, h, now.v);
  }
  return now;
}

Vec3 narrow(const std::array<Wide, 3>& v) { return {double(v[0]), double(v[1]), double(v[2])}; }
double apart(const Vec3& a, const Vec3& b) {
  const Vec3 d = plus(a, -1, b);
  return std::sqrt(along(d, d));
}
// Body rate in world axes.
Vec3 turned(const BodySample& b) {
  const Vec3 u{double(b.q_wxyz[1]), double(b.q_wxyz[2]), double(b.q_wxyz[3])}, w = narrow(b.w_rad_per_s);
  return plus(w, 2, times(u, plus(times(u, w), double(b.q_wxyz[0]), w)));
}

}  // namespace

namespace {

void require_march(const Scenario& given) {
  const Truth truth = closed_form_truth(given, given.samples);
  INFO(given.id << ": " << truth.outcome.reason);
  REQUIRE(truth.outcome.status == Status::ok);
  const Plane& plane = std::get<Plane>(given.scene.bodies.back().shape);
  for (std::size_t i = 0; i + 1 < given.scene.bodies.size(); ++i) {
    const double height = along(plane.normal, given.scene.bodies[i].position_m);
    const BodySample& end = truth.values.back().bodies[i];
    const Moving near = march(given.scene, static_cast<int>(i), plane.normal, height, given.t_end_s, 200000);
    INFO(given.scene.bodies[i].name);
    CHECK(apart(near.p, narrow(end.p_m)) < 1e-4);
    CHECK(apart(near.v, narrow(end.v_m_per_s)) < 1e-4);
    CHECK(apart(near.w, turned(end)) < 1e-3);
    CHECK(static_cast<double>(truth.bars.back().bodies[i].p_m[0]) < 1e-14);
  }
}

}  // namespace

TEST_CASE("Scenes on a floor end where an integration in small steps with Coulomb's cone ends") {
  for (const char* id : {"slide-3", "slide-10", "slide-20", "slide-30", "slide-40", "stop-distance", "stop-distance-0",
                         "stop-distance-30", "stop-distance-45", "stop-distance-60", "roll", "roll-hollow",
                         "roll-cylinder", "roll-slip", "slip-to-roll", "slip-to-roll-backspin"})
    require_march(catalogued(id));
}

TEST_CASE("Thrown up a slope: boxes stay or come back, balls skid, roll up and down, or spin on the spot; topspin") {
  Scenario given = catalogued("slide-30");
  const Real3 n = std::get<Plane>(given.scene.bodies.back().shape).normal;
  for (std::size_t i = 0; i + 1 < given.scene.bodies.size(); ++i)
    given.scene.bodies[i].velocity_m_per_s = {-2 * n[2], 0, 2 * n[0]};
  require_march(given);
  const Truth truth = closed_form_truth(given, 60);
  CHECK(truth.events.size() == 2);  // mu = 0.7 and 1 stick; the others turn round
  for (const char* id : {"roll", "roll-slip"})
    for (const double spin : {-40.0, 0.0, 40.0}) {
      given = catalogued(id);
      given.scene.bodies[0].velocity_m_per_s = {-2 * n[2], 0, 2 * n[0]};
      given.scene.bodies[0].angular_velocity_body_rad_per_s = {0, spin, 0};
      require_march(given);
    }
  given = catalogued("slip-to-roll");
  given.scene.bodies[0].angular_velocity_body_rad_per_s = {0, 40, 0};
  require_march(given);
}

TEST_CASE("Boxes stop after v0^2 / (2 mu g) at v0 / (mu g), on their line, and stay") {
  for (const char* id : {"stop-distance-0", "stop-distance-30", "stop-distance-45", "stop-distance-60"}) {
    const Scenario given = catalogued(id);
    const Truth truth = closed_form_truth(given, given.samples);
    REQUIRE(truth.events.size() == 3);
    for (int i = 0; i < 3; ++i) {
      const Wide mu = i == 0 ? 0.2 : i == 1 ? 0.4 : 0.7, g = 9.81;
      const BodySample& end = truth.values.back().bodies[i];
      const Real3 &p0 = given.scene.bodies[i].position_m, &v0 = given.scene.bodies[i].velocity_m_per_s;
      const Wide x = end.p_m[0] - p0[0], y = end.p_m[1] - p0[1], speed2 = Wide(v0[0]) * v0[0] + Wide(v0[1]) * v0[1];
      CHECK(static_cast<double>(fabsq(sqrtq(x * x + y * y) - speed2 / (2 * mu * g))) < 1e-30);
      CHECK(static_cast<double>(fabsq(x * v0[1] - y * v0[0])) < 1e-30);
      CHECK(end.v_m_per_s == std::array<Wide, 3>{});
      CHECK(truth.events[2 - i].kind == EventKind::stick);  // the roughest first
      CHECK(static_cast<double>(fabsq(truth.events[2 - i].t_s - sqrtq(speed2) / (mu * g))) < 1e-30);
      CHECK(end.p_m[2] == Wide(0.05));
    }
  }
}

TEST_CASE("On a slope: sliding and sticking boxes, rolling and slipping balls") {
  for (const int degrees : {3, 10, 20, 30, 40}) {
    const Scenario given = catalogued("slide-" + std::to_string(degrees));
    const Truth truth = closed_form_truth(given, given.samples);
    const double tangent = std::tan(degrees * M_PI / 180), mus[] = {0.1, 0.3, 0.5, 0.7, 1};
    for (int i = 0; i < 5; ++i) {
      const Vec3 v = narrow(truth.values.back().bodies[i].v_m_per_s);
      const double a = mus[i] >= tangent ? 0 : 9.81 * (tangent - mus[i]) * std::cos(degrees * M_PI / 180);
      CHECK(std::sqrt(along(v, v)) == Approx(a * given.t_end_s).margin(1e-14));
    }
  }
  // Power of gravity goes into both kinds of kinetic energy of what rolls, and no torque acts about the line of
  // contact: m g sin r t = (I + m r^2) w.
  for (const auto& [id, share] : {std::pair{"roll", 5.0 / 7}, {"roll-hollow", 3.0 / 5}, {"roll-cylinder", 2.0 / 3}}) {
    const Truth truth = closed_form_truth(catalogued(id), 60);
    const Vec3 v = narrow(truth.values.back().bodies[0].v_m_per_s),
               w = narrow(truth.values.back().bodies[0].w_rad_per_s);
    CHECK(std::sqrt(along(v, v)) == Approx(share * 9.81 / 2).epsilon(1e-14));
    CHECK(std::sqrt(along(w, w)) == Approx(share * 9.81 / 2 / 0.125).epsilon(1e-14));
    CHECK(truth.events.empty());
  }
  const Truth slips = closed_form_truth(catalogued("roll-slip"), 60);
  const Vec3 w = narrow(slips.values.back().bodies[0].w_rad_per_s);
  CHECK(std::sqrt(along(w, w)) == Approx(2.5 * 0.1 * 9.81 * std::cos(M_PI / 6) / 0.125).epsilon(1e-14));
}

TEST_CASE("A sliding ball rolls from 2 v0 / (7 mu g) on; angular momentum about the ground's line stays") {
  for (const char* id : {"slip-to-roll", "slip-to-roll-backspin"}) {
    const Scenario given = catalogued(id);
    const Truth truth = closed_form_truth(given, given.samples);
    REQUIRE(truth.events.size() == 1);
    CHECK(truth.events[0].kind == EventKind::roll);
    const double r = 0.125, v0 = given.scene.bodies[0].velocity_m_per_s[0];
    const double w0 = given.scene.bodies[0].angular_velocity_body_rad_per_s[1], slip0 = v0 - r * w0;
    CHECK(static_cast<double>(truth.events[0].t_s) == Approx(2 * slip0 / (7 * 0.3 * 9.81)).epsilon(1e-14));
    for (const SampleView s : truth.values) {
      const double v = static_cast<double>(s.bodies[0].v_m_per_s[0]),
                   spin = static_cast<double>(s.bodies[0].w_rad_per_s[1]);
      CHECK(v + 0.4 * r * spin == Approx(v0 + 0.4 * r * w0).epsilon(1e-14));
      if (s.t_s > truth.events[0].t_s) CHECK(v == Approx(r * spin).epsilon(1e-14));
    }
    CHECK(static_cast<double>(truth.values.back().bodies[0].v_m_per_s[0]) ==
          Approx((5 * v0 + 2 * r * w0) / 7).epsilon(1e-14));
  }
}

TEST_CASE("Bodies that leave their line, tip over or have no floor are refused by name") {
  const auto why = [](const Scenario& given) {
    const Truth truth = closed_form_truth(given, 60);
    CHECK(truth.outcome.status == Status::unsupported);
    return truth.outcome.reason;
  };
  Scenario given = catalogued("slide-30");
  given.scene.bodies[1].velocity_m_per_s = {0, 0.5, 0};
  CHECK_THAT(why(given), Catch::Contains("`box-0.3` does not move along one line"));
  given = catalogued("stop-distance");
  std::get<Box>(given.scene.bodies[0].shape).half_extents_m = {0.02, 0.02, 0.06};
  given.scene.bodies[0].position_m[2] = 0.06;
  CHECK_THAT(why(given), Catch::Contains("would tip"));
  given.scene.bodies[0].position_m[2] = 0.07;
  CHECK_THAT(why(given), Catch::Contains("does not touch"));
  given = catalogued("stop-distance-0");
  given.scene.bodies[1].position_m = {0.7, 0, 0.05};
  CHECK_THAT(why(given), Catch::Contains("could touch each other"));
  given = catalogued("roll-cylinder");
  given.scene.bodies[0].orientation_wxyz = {0.8, 0.6, 0, 0};
  CHECK_THAT(why(given), Catch::Contains("does not lie on its side"));
}

TEST_CASE("A flat mesh is a plane as far as it goes") {
  for (const char* id : {"mesh-floor-roll", "mesh-floor-slide"}) {
    Scenario given = catalogued(id);
    const Truth mesh = closed_form_truth(given, 90);
    INFO(mesh.outcome.reason);
    REQUIRE(mesh.outcome.status == Status::ok);
    given.t_end_s = 6;
    if (given.id == "mesh-floor-roll")
      CHECK_THAT(closed_form_truth(given, 90).outcome.reason, Catch::Contains("reaches the boundary"));
    given.t_end_s = 1.5;
    given.scene.bodies[0].position_m[0] = 6;
    CHECK_THAT(closed_form_truth(given, 90).outcome.reason, Catch::Contains("reaches the boundary"));
    given = catalogued(id);
    given.scene.bodies[1].shape = Plane{{0, 0, 1}, 0};
    const Truth plane = closed_form_truth(given, 90);
    for (std::size_t k = 0; k < plane.values.size(); ++k) {
      CHECK(mesh.values[k].bodies[0].p_m == plane.values[k].bodies[0].p_m);
      CHECK(mesh.values[k].bodies[0].w_rad_per_s == plane.values[k].bodies[0].w_rad_per_s);
    }
    std::get<Mesh>(given.scene.bodies[1].shape = catalogued(id).scene.bodies[1].shape).points_m[80][2] = 0.01;
    CHECK_THAT(closed_form_truth(given, 90).outcome.reason, Catch::Contains("is not flat"));
  }
}
