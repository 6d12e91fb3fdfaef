// Contacts that last under `+event`: closed forms, the kinds and times of events, forces at samples.
#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

#include "recorded.hpp"
#include "scene/scene.hpp"
#include "simulation.hpp"

using namespace atwood;
using recorded::Recorded;
using recorded::run;

namespace {

constexpr double g = 9.8;

Scene on_floor(Shape shape, const Real3& I, double height_m, double friction, double rolling_friction_m = 0) {
  Scene scene;
  scene.gravity_m_per_s2 = {0, 0, -g};
  scene.materials = {{"stuff", 0, friction, rolling_friction_m}};
  scene.pairs = {{0, 0, 0, friction, rolling_friction_m}};
  Body floor, body;
  floor.name = "floor";
  floor.shape = Plane{{0, 0, 1}, 0};
  floor.fixed = true;
  body.name = "body";
  body.mass_kg = 2;
  body.inertia_kg_m2 = {2 * I[0], 0, 0, 0, 2 * I[1], 0, 0, 0, 2 * I[2]};
  body.shape = std::move(shape);
  body.position_m = {0, 0, height_m};
  scene.bodies = {floor, body};
  return scene;
}

Scene ball(double r, double friction, double rolling_friction_m = 0) {
  return on_floor(Sphere{r}, {0.4 * r * r, 0.4 * r * r, 0.4 * r * r}, r, friction, rolling_friction_m);
}
Scene box(double friction) {
  return on_floor(Box{{0.2, 0.2, 0.05}}, {0.0425 / 3, 0.0425 / 3, 0.08 / 3}, 0.05, friction);
}

double at(const Recorded& r, int axis) { return static_cast<double>(r.samples.back().bodies[1].p_m[axis]); }
double speed(const Recorded& r, int axis) { return static_cast<double>(r.samples.back().bodies[1].v_m_per_s[axis]); }

}  // namespace

TEST_CASE("a run says how its events were located") {
  Scene sliding = box(0.3), thrown = ball(0.1, 0.3);
  sliding.bodies[1].velocity_m_per_s = {2, 0, 0};
  thrown.bodies[1].position_m[2] = 1;
  thrown.bodies[1].velocity_m_per_s = {2, 0, 0};
  for (const Scene& scene : {sliding, thrown}) {
    const auto r = run("atwood/rk4+event", scene, {1, 50, 50});
    REQUIRE(r.outcome.status == Status::ok);
    REQUIRE(!r.events.empty());
    const SolveTally& tally = r.outcome.solvers.at("event-location");
    CHECK(tally.converged >= 1);
    CHECK(tally.capped == 0);
    CHECK(tally.iterations_max >= 1);
    CHECK(tally.residual_max <= 1e-13);
  }
}

TEST_CASE("a sliding ball rolls at 2 v0 / (7 mu g) with 5/7 of its speed") {
  const double v0 = 2, mu = 0.3, t_roll = 2 * v0 / (7 * mu * g);
  Scene scene = ball(0.1, mu);
  scene.bodies[1].velocity_m_per_s = {v0, 0, 0};
  for (const char* method :
       {"atwood/rk4+event", "atwood/dopri5+event", "atwood/velocity-verlet+event", "atwood/gauss4+event"}) {
    INFO(method);
    const auto r = run(method, scene, {1, 50, 50});
    REQUIRE(r.events.size() == 1);
    CHECK(r.events[0].kind == EventKind::roll);
    CHECK(static_cast<double>(r.events[0].t_s) == Approx(t_roll).epsilon(1e-12));
    CHECK(speed(r, 0) == Approx(5 * v0 / 7).epsilon(1e-12));
    CHECK(at(r, 0) == Approx(v0 * t_roll - mu * g * t_roll * t_roll / 2 + 5 * v0 / 7 * (1 - t_roll)).epsilon(1e-12));
  }
}

TEST_CASE("a box stops after v0^2 / (2 mu g), on its line whatever its direction, and stays") {
  const double v0 = 2, mu = 0.4;
  for (const double degrees : {0., 17., 30., 45., 60., 81.}) {
    INFO(degrees);
    const double c = std::cos(degrees * M_PI / 180), s = std::sin(degrees * M_PI / 180);
    Scene scene = box(mu);
    scene.bodies[1].velocity_m_per_s = {v0 * c, v0 * s, 0};
    const auto r = run("atwood/rk4+event", scene, {1, 60, 60});
    REQUIRE(r.events.size() == 1);
    CHECK(r.events[0].kind == EventKind::stick);
    CHECK(static_cast<double>(r.events[0].t_s) == Approx(v0 / (mu * g)).epsilon(1e-11));
    const double way = v0 * v0 / (2 * mu * g);
    CHECK(std::abs(at(r, 0) * c + at(r, 1) * s - way) < 1e-11);
    CHECK(std::abs(at(r, 1) * c - at(r, 0) * s) < 1e-11);
    double carried = 0;
    for (const auto& contact : r.samples.back().contacts) carried += contact.force_n_N;
    CHECK(carried == Approx(2 * g).epsilon(1e-11));
  }
}

TEST_CASE("rolling friction brings a rolling ball to rest") {
  // I alpha = -delta N + r F, m a = -F, a = r alpha:  a = -(5/7) delta g / r.
  const double r = 0.1, delta = 0.01, v0 = 1, a = 5.0 / 7 * delta * g / r;
  Scene scene = ball(r, 0.5, delta);
  scene.bodies[1].velocity_m_per_s = {v0, 0, 0};
  scene.bodies[1].angular_velocity_body_rad_per_s = {0, v0 / r, 0};
  const auto result = run("atwood/rk4+event", scene, {2, 100, 100});
  CHECK(at(result, 0) == Approx(v0 * v0 / (2 * a)).epsilon(1e-10));
  CHECK(std::abs(speed(result, 0)) < 1e-12);
}

TEST_CASE("balls fall on sheets, boxes and capsules, boxes on sheets, and meet them within the step") {
  const double drop = 0.5, t_touch = std::sqrt(2 * drop / g), end_s = 0.4;
  Scene onto = ball(0.1, 0);
  onto.pairs = {{0, 0, 0.5, 0, 0}};
  for (const bool falling_box : {false, true})
    for (const Shape& under : {Shape{Rectangle{{1, 1}}}, Shape{Box{{1, 1, 0.25}}}, Shape{Capsule{0.25, 1}}}) {
      if (falling_box && !std::holds_alternative<Rectangle>(under)) continue;
      INFO(falling_box << " on shape " << under.index());
      Scene scene = onto;
      scene.bodies[0].shape = under;
      const double top = std::holds_alternative<Rectangle>(under) ? 0 : 0.25;
      if (std::holds_alternative<Capsule>(under))
        scene.bodies[0].orientation_wxyz = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};
      if (falling_box) scene.bodies[1].shape = Box{{0.1, 0.1, 0.1}};
      scene.bodies[1].position_m = {0, 0, top + 0.1 + drop};
      for (const int steps : {3, 7, 100}) {
        INFO(steps << " steps");
        const auto r = run("atwood/rk4+event", scene, {end_s, steps, 1});
        REQUIRE(r.events.size() == 1);
        CHECK(r.events[0].kind == EventKind::impact);
        CHECK(static_cast<double>(r.events[0].t_s) == Approx(t_touch).epsilon(1e-14));
        CHECK(speed(r, 2) == Approx(0.5 * g * t_touch - g * (end_s - t_touch)).epsilon(1e-12));
      }
    }
}

TEST_CASE("a box under a slowly growing pull lets go as one, along the pull") {
  // F(t) = m c sin(w t) along d through the centre; slip sets in at mu g = c sin(w t), then v = (c/w)(cos(w t0) - cos(w
  // t)) - mu g (t - t0).
  const double mu = 0.4, c = 8, w = 0.5, m = 2, t0 = std::asin(mu * g / c) / w, end_s = 2;
  const double moved = c / w * (std::cos(w * t0) - std::cos(w * end_s)) - mu * g * (end_s - t0);
  for (const double degrees : {0., 17., 45., 71.}) {
    INFO(degrees);
    const double along = std::cos(degrees * M_PI / 180), beside = std::sin(degrees * M_PI / 180);
    Scene scene = box(mu);
    scene.forces.push_back(Drive{{1}, {m * c * along, m * c * beside, 0}, w, -M_PI / 2});
    const auto r = run("atwood/rk4+event", scene, {end_s, 400, 100});
    REQUIRE(r.events.size() == 1);
    CHECK(r.events[0].kind == EventKind::slip);
    CHECK(static_cast<double>(r.events[0].t_s) == Approx(t0).epsilon(1e-9));
    CHECK(speed(r, 0) * along + speed(r, 1) * beside == Approx(moved).epsilon(1e-8));
    CHECK(std::abs(speed(r, 1) * along - speed(r, 0) * beside) < 1e-10);
    for (const auto& w_B : r.samples.back().bodies[1].w_rad_per_s) CHECK(std::abs(static_cast<double>(w_B)) < 1e-10);
  }
}
