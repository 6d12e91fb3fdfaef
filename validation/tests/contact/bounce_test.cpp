// Bouncing balls: located impacts against closed forms, plain time stepping against its own order.
#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

#include "recorded.hpp"
#include "scene/scene.hpp"
#include "simulation.hpp"

using namespace atwood;
using recorded::Recorded;
using recorded::run;
using recorded::try_run;

namespace {

constexpr double g = 9.8, radius = 0.1;

Scene ball_over_plane(double clearance_m, double restitution) {
  Scene scene;
  scene.gravity_m_per_s2 = {0, 0, -g};
  scene.materials = {{"rubber", restitution, 0, 0}};
  scene.pairs = {{0, 0, restitution, 0, 0}};
  Body plane;
  plane.name = "floor";
  plane.shape = Plane{{0, 0, 1}, 0};
  plane.fixed = true;
  Body ball;
  ball.name = "ball";
  ball.mass_kg = 2;
  const double I = 0.4 * ball.mass_kg * radius * radius;
  ball.inertia_kg_m2 = {I, 0, 0, 0, I, 0, 0, 0, I};
  ball.shape = Sphere{radius};
  ball.position_m = {0, 0, radius + clearance_m};
  scene.bodies = {plane, ball};
  return scene;
}

// Height of the ball's lowest point at t: impacts at t_0 = sqrt(2 h / g), then flights of 2 e^k v / g.
double height_at(double h, double e, double t) {
  const double v = std::sqrt(2 * g * h), t0 = std::sqrt(2 * h / g);
  if (t <= t0) return h - g * t * t / 2;
  double start = t0, speed = e * v;
  while (speed > 1e-9 && t > start + 2 * speed / g) {
    start += 2 * speed / g;
    speed *= e;
  }
  return speed > 1e-9 ? speed * (t - start) - g * (t - start) * (t - start) / 2 : 0;
}

}  // namespace

TEST_CASE("five apexes of rk4+event to 1e-12 from any clearance") {
  for (const double clearance : {1e-3, 0.0137, 0.1, 0.5, 1.0, 3.21}) {
    const double e = 0.8;
    const double t_end = std::sqrt(2 * clearance / g) *
                         (1 + 2 * (e + std::pow(e, 2) + std::pow(e, 3) + std::pow(e, 4) + std::pow(e, 5)));
    const auto steps = static_cast<std::int64_t>(std::ceil(t_end * 240));
    const auto r = run("atwood/rk4+event", ball_over_plane(clearance, e), {t_end, steps, 1});
    REQUIRE(r.events.size() >= 5);
    for (int k = 0; k < 5; ++k) {
      const double v_after = static_cast<double>(r.events[k].vn_after_m_per_s);
      const double apex = v_after * v_after / (2 * g), expected = clearance * std::pow(e, 2 * (k + 1));
      INFO("clearance " << clearance << " apex " << k + 1);
      CHECK(std::abs(apex / expected - 1) < 1e-12);
    }
  }
}

TEST_CASE("a bouncing ball comes to rest when its series ends, and stays") {
  const double h = 1, e = 0.5;
  const auto r = run("atwood/rk4+event", ball_over_plane(h, e), {4, 960, 60});
  REQUIRE(!r.events.empty());
  const Event& last = r.events.back();
  CHECK(last.kind == EventKind::rest);
  CHECK(static_cast<double>(last.t_s) ==
        Approx(std::sqrt(2 * h / g) * (1 + e) / (1 - e)).epsilon(1e-11));  // eps r / v at the last bounce
  for (std::size_t k = 0; k < r.samples.size(); ++k) {
    CHECK(std::abs(static_cast<double>(r.samples[k].bodies[1].p_m[2]) - radius -
                   height_at(h, e, 4.0 * static_cast<double>(k) / 60)) < 1e-12);
  }
  CHECK(static_cast<double>(r.samples.back().bodies[1].v_m_per_s[2]) == 0);
}

TEST_CASE("e = 0 rests at first touch; e = 1 keeps its energy") {
  const auto dead = run("atwood/rk4+event", ball_over_plane(0.3, 0), {2, 480, 60});
  REQUIRE(dead.events.size() == 2);
  CHECK(dead.events[1].kind == EventKind::rest);
  const auto live = run("atwood/rk4+event", ball_over_plane(0.3, 1), {20, 4800, 60});
  const auto& end = live.samples.back().bodies[1];
  const double z = static_cast<double>(end.p_m[2]) - radius, v = static_cast<double>(end.v_m_per_s[2]);
  CHECK((v * v / 2 + g * z) == Approx(g * 0.3).epsilon(1e-12));
}

TEST_CASE("time stepping is first order and keeps a ball where it came to rest") {
  const double h = 1, e = 0.8, t = 1.0;
  std::vector<double> errors;
  for (const int steps : {240, 480, 960, 1920}) {
    const auto r = run("atwood/rk4+impulse", ball_over_plane(h, e), {t, steps, 60});
    errors.push_back(std::abs(static_cast<double>(r.samples.back().bodies[1].p_m[2]) - radius - height_at(h, e, t)));
  }
  CHECK(errors[3] < 1e-2);
  CHECK(errors[3] < errors[0]);
  const auto rest = run("atwood/symplectic-euler+impulse", ball_over_plane(0.2, 0.3), {10, 2400, 60});
  const double z_late = static_cast<double>(rest.samples[30].bodies[1].p_m[2]),
               z_end = static_cast<double>(rest.samples[60].bodies[1].p_m[2]);
  CHECK(std::abs(z_end - z_late) < 1e-10);
  CHECK(std::abs(z_end - radius) < g / 240 / 240);
}

TEST_CASE("impact times under quadratic drag keep order 4, kink at the top of each bounce and all") {
  // Impacts of a long double run at a quarter of the finest step stand for the truth.
  Scene scene = ball_over_plane(1, 0.8);
  QuadraticDrag drag;
  drag.bodies = {1};
  drag.density_kg_per_m3 = 30;
  drag.drag_coefficient = 0.47;
  drag.area_m2 = 0.0314;
  scene.forces = {drag};
  auto third_impact = [&](const std::string& method, std::int64_t steps) {
    const auto r = run(method, scene, {2, steps, 1});
    REQUIRE(r.events.size() >= 3);
    return static_cast<double>(r.events[2].t_s);
  };
  const double truth = third_impact("atwood/rk4+event@long-double", 15360);
  const double coarse = std::abs(third_impact("atwood/rk4+event", 120) - truth);
  const double fine = std::abs(third_impact("atwood/rk4+event", 480) - truth);
  CHECK(fine < 1e-9);
  CHECK(std::log2(coarse / fine) / 2 == Approx(4).margin(0.35));
}

TEST_CASE("a glancing touch inside one long step is found") {
  Scene scene;
  scene.materials = {{"ivory", 1, 0, 0}};
  scene.pairs = {{0, 0, 1, 0, 0}};
  Body a, b;
  a.name = "a";
  b.name = "b";
  a.mass_kg = b.mass_kg = 1;
  const double I = 0.4 * 0.25;
  a.inertia_kg_m2 = b.inertia_kg_m2 = {I, 0, 0, 0, I, 0, 0, 0, I};
  a.shape = b.shape = Sphere{0.5};
  a.position_m = {-50, 0.99, 0};
  a.velocity_m_per_s = {100, 0, 0};
  scene.bodies = {a, b};
  const auto r = run("atwood/rk4+event", scene, {1, 1, 1});
  REQUIRE(r.events.size() == 1);
  const double x = -std::sqrt(1 - 0.99 * 0.99);
  CHECK(static_cast<double>(r.events[0].t_s) == Approx((x + 50) / 100).epsilon(1e-13));
}

TEST_CASE("a pair without a contact test is refused by name once its bodies come near") {
  Scene scene = ball_over_plane(1, 0.5);
  scene.bodies[1].shape = Cylinder{0.1, 0.1};
  Body other = scene.bodies[1];
  other.name = "other";
  other.position_m = {0, 0, 5};
  scene.bodies.push_back(other);
  scene.bodies[1].velocity_m_per_s = {0, 0, 6};
  const auto r = try_run("atwood/rk4+event", scene, {1, 60, 60});
  CHECK(r.outcome.status == Status::unsupported);
  CHECK(r.outcome.reason.find("cylinder `ball` and cylinder `other`") != std::string::npos);
  scene.bodies[2].position_m = {3, 0, 5};  // far enough to the side
  run("atwood/rk4+event", scene, {1, 60, 60});
}
