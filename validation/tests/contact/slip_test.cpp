// Where slip ends, turns or sets in under `+event`: next to the angle of friction, with side spin, aslant on a slope.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <random>
#include <string>

#include "recorded.hpp"

using namespace atwood;
using namespace atwood::recorded;

namespace {

constexpr double g = 9.81;

// A plane that falls towards +x at `angle`, and a body whose axes are the plane's.
struct Slope {
  double c, s;
  explicit Slope(double angle) : c(std::cos(angle)), s(std::sin(angle)) {}
  Real3 normal() const { return {s, 0, c}; }
  Real3 at(double down, double aside, double up) const { return {c * down + s * up, aside, -s * down + c * up}; }
  double down(const Real3& v) const { return c * v[0] - s * v[2]; }
};

Scene on_slope(double angle, double friction, Body body, double height) {
  const Slope slope(angle);
  Scene scene = world({0, 0, -g}, 0, friction);
  body.position_m = slope.at(0, 0, height);
  body.orientation_wxyz = {std::cos(angle / 2), 0, std::sin(angle / 2), 0};
  scene.bodies = {fixed("slope", Plane{slope.normal(), 0}), body};
  return scene;
}

}  // namespace

TEST_CASE("a box stays at rest just below the angle of friction and slides just above it") {
  const double mu = 0.5, t_end = 2;
  for (const double off : {1e-3, 1e-5, 1e-7, 1e-9})
    for (const double sign : {-1., 1.})
      for (const double speed : {0., 0.3}) {
        const double angle = std::atan(mu) + sign * off;
        const Slope slope(angle);
        Scene scene = on_slope(angle, mu, box("box", 3, {0.4, 0.3, 0.05}, {}), 0.05);
        scene.bodies[1].velocity_m_per_s = slope.at(speed, 0, 0);
        const Recorded it = run("atwood/rk4+event", scene, {t_end, 120, 1});
        INFO(sign * off << " rad, thrown at " << speed << " m/s");
        const double a = sign < 0 && speed == 0 ? 0 : g * (slope.s - mu * slope.c);
        CHECK(std::abs(slope.down(it.v(1)) - (speed + a * t_end)) < 1e-10);
        CHECK(std::abs(it.v(1)[1]) < 1e-10);
      }
}

// b v + a v cos(phi), a = g sin, b = mu g cos, phi from the way down: falls by b^2 - a^2 a second, whatever the path.
TEST_CASE("a box thrown aslant over a slope stops when its balance says, however its slip turns") {
  const double mu = 0.5, v0 = 2, angle = 0.3, a = g * std::sin(angle), b = mu * g * std::cos(angle);
  for (const double phi : {0.5, 1.3, 2.2, 3.1}) {
    Scene scene = on_slope(angle, mu, box("box", 3, {0.4, 0.5, 0.05}, {}), 0.05);
    scene.bodies[1].velocity_m_per_s = Slope(angle).at(v0 * std::cos(phi), v0 * std::sin(phi), 0);
    const double stops = v0 * (b + a * std::cos(phi)) / (b * b - a * a);
    const Recorded it = run("atwood/rk4+event", scene, {1.5 * stops, 120, 1});
    INFO("phi " << phi);
    REQUIRE(it.events.size() == 1);
    CHECK(it.events[0].kind == EventKind::stick);
    CHECK(std::abs(time_of(it.events[0]) - stops) < 1e-6);
  }
}

TEST_CASE("a box thrown up a slope that does not hold it turns about") {
  const double mu = 0.45, v0 = 2, angle = 0.5, a = g * std::sin(angle), b = mu * g * std::cos(angle), phi = 3.13;
  const Slope slope(angle);
  Scene scene = on_slope(angle, mu, box("box", 3, {0.4, 0.5, 0.05}, {}), 0.05);
  scene.bodies[1].velocity_m_per_s = slope.at(v0 * std::cos(phi), v0 * std::sin(phi), 0);
  for (const auto& [method, most] : {std::pair{"atwood/rk4+event", 1e-6}, std::pair{"atwood/rk4+event@float", 5e-4}}) {
    const Recorded it = run(method, scene, {1, 64, 1});
    INFO(method);
    const double balance = b * std::hypot(slope.down(it.v(1)), it.v(1)[1]) + a * slope.down(it.v(1));
    CHECK(std::abs(balance - v0 * (b + a * std::cos(phi)) - (a * a - b * b)) < most * a);
  }
}

TEST_CASE("a ball with side spin rolls after |u| / (3.5 mu g)") {
  const double mu = 0.15, r = 0.1;
  Scene scene = world({0, 0, -g}, 0, mu);
  scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), ball("ball", 2, r, {0, 0, r}, {-0.25, 1, 0}, {7, -11, -3})};
  const double ux = -0.25 + 11 * r, uy = 1 + 7 * r, rolls = std::hypot(ux, uy) / (3.5 * mu * g);
  double before = 1;
  for (const int steps : {60, 120, 240}) {
    const Recorded it = run("atwood/rk4+event", scene, {1, steps, 1});
    INFO(steps << " steps");
    REQUIRE(it.events.size() == 1);
    CHECK(it.events[0].kind == EventKind::roll);
    const double error = std::abs(time_of(it.events[0]) - rolls);
    CHECK(error < 0.003 * std::pow(60. / steps, 2) * 1e-3);
    CHECK(error < before / 6);  // of third order at least
    before = error;
    CHECK(std::abs(it.v(1)[0] - (-0.25 - 2 * ux / 7)) < 1e-5);
    CHECK(std::abs(it.v(1)[1] - (1 - 2 * uy / 7)) < 1e-5);
  }
}

// What slows the slip, 3.5 mu g cos less g sin along it, is a tenth of what friction alone would: many small parts of
// its last time. They ended nowhere where slip was round-off already.
TEST_CASE("a ball that friction hardly lets roll comes to roll") {
  const double r = 0.1, mu = 0.3, I = 2. / 3 * r * r;  // rolls above 2/5 tan = 0.274
  const Real3 n = {0.3109505520850398, 0.4713076245083164, 0.8253356149096783};
  Scene scene = world({0, 0, -g}, 0, mu);
  scene.bodies = {fixed("slope", Plane{n, 0}),
                  moving("ball", Sphere{r}, 2, {I, I, I}, {r * n[0], r * n[1], r * n[2]},
                         {-0.16409315154305976, -0.023699048167993064, 0.07535649381574294},
                         {-5.197597723701788, 1.602267063174243, -3.803527272151388})};
  const Recorded it = run("atwood/rk4+event", scene, {1, 100, 1});
  REQUIRE(it.events.size() == 1);
  CHECK(it.events[0].kind == EventKind::roll);
  CHECK(std::abs(time_of(it.events[0]) - 0.08948696) < 1e-5);  // by DOP853 at 1e-13
}

TEST_CASE("a box that slides into a wall without restitution stays there at rest") {
  const double mu = 0.2, v0 = 2.5;
  Scene scene = world({0, 0, -g}, 0, mu);
  scene.materials.push_back({"wall", 0, 0, 0});
  scene.pairs = {{0, 0, 0, mu, 0}, {0, 1, 0, 0, 0}, {1, 1, 0, 0, 0}};
  scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), fixed("wall", Plane{{-1, 0, 0}, -1}),
                  box("box", 1, {0.2, 0.2, 0.1}, {0, 0, 0.1}, {v0, 0, 0})};
  scene.bodies[1].material = 1;
  const Recorded it = run("atwood/rk4+event", scene, {1, 100, 1});
  CHECK(std::abs(it.p(2)[0] - 0.8) < 1e-13);
  CHECK(std::abs(it.v(2)[0]) < 1e-15);
  CHECK(it.count(EventKind::impact) == 1);
  CHECK(time_of(it.events[0]) == Approx((v0 - std::sqrt(v0 * v0 - 2 * mu * g * 0.8)) / (mu * g)).epsilon(1e-12));
  for (const auto& contact : it.samples.back().contacts)
    if (contact.body_a == 1) CHECK(contact.force_n_N < 1e-9);
}

// The slab takes m v (1 + e) M / (m + M) and gives it to the floor: the ball rises with (e M - m) / (M + m) of its
// speed.
TEST_CASE("a ball's bounces on a slab that lies on the floor end when their series does") {
  const double r = 0.1, h = 0.2, e = 0.6, M = 10, m = 1, ratio = (e * M - m) / (M + m), t1 = std::sqrt(2 * h / g);
  Scene scene = world({0, 0, -g}, 0, 0);
  scene.materials.push_back({"ball", 0, 0, 0});
  scene.pairs = {{0, 0, 0, 0, 0}, {0, 1, e, 0, 0}, {1, 1, 0, 0, 0}};
  scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), box("slab", M, {5, 1, 0.1}, {0, 0, 0.1}),
                  ball("ball", m, r, {0, 0, 0.3 + h})};
  scene.bodies[2].material = 1;
  const Recorded it = run("atwood/rk4+event", scene, {1, 50, 1});
  REQUIRE(it.count(EventKind::rest) >= 1);
  CHECK(it.events.back().kind == EventKind::rest);
  CHECK(time_of(it.events.back()) == Approx(t1 * (1 + ratio) / (1 - ratio)).epsilon(1e-11));
  CHECK(std::abs(it.p(2)[2] - 0.3) < 1e-14);
  CHECK(std::abs(it.v(2)[2]) < 1e-14);
}

// With M = 2 m and e = 1/2 the floor takes all that the ball has left: it rests where it has bounced.
TEST_CASE("a ball whose bounce the floor under its slab uses up comes to rest there") {
  Scene scene = world({0, 0, -g}, 0, 0);
  scene.materials.push_back({"ball", 0, 0, 0});
  scene.pairs = {{0, 0, 0, 0, 0}, {0, 1, 0.5, 0, 0}, {1, 1, 0, 0, 0}};
  scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), box("slab", 2, {0.3, 0.3, 0.1}, {0, 0, 0.1}),
                  ball("ball", 1, 0.1, {0, 0, 0.5})};
  scene.bodies[2].material = 1;
  const Recorded it = run("atwood/rk4+event", scene, {0.5, 50, 1});
  CHECK(it.count(EventKind::rest) == 1);
  CHECK(time_of(it.events.back()) == Approx(std::sqrt(2 * 0.2 / g)).epsilon(1e-13));
  CHECK(std::abs(it.p(2)[2] - 0.3) < 1e-14);
}

TEST_CASE("boxes that tumble, slide and spin come to rest on a face") {
  std::mt19937 random(11);
  const auto any = [&](double most) { return std::uniform_real_distribution<double>(-most, most)(random); };
  const Real3 half = {0.2, 0.15, 0.1};
  for (int i = 0; i < 20; ++i) {
    const double e = std::array{0., 0.3, 0.5}[i % 3], mu = std::array{0.3, 1.}[i / 3 % 2];
    Scene scene = world({0, 0, -g}, e, mu);
    scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), box("box", 2, half, {0, 0, 0.6}, {any(1), any(1), 0})};
    Body& body = scene.bodies[1];
    const Real4 q = {any(1), any(1), any(1), any(1)};
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; ++k) body.orientation_wxyz[k] = q[k] / length;
    body.angular_velocity_body_rad_per_s = {any(3), any(3), any(3)};
    const Recorded it =
        run(std::string("atwood/rk4+event{restitution=") + (i % 2 ? "stronge" : "poisson") + "}", scene, {4, 400, 80});
    INFO(i << " e " << e << " mu " << mu << " " << it.outcome.reason);
    double before = 1e9;
    for (const Sample& sample : it.samples) {
      const Real3 v = Recorded::doubles(sample.bodies[1].v_m_per_s),
                  w = Recorded::doubles(sample.bodies[1].w_rad_per_s);
      double energy = body.mass_kg * g * static_cast<double>(sample.bodies[1].p_m[2]);
      for (int k = 0; k < 3; ++k) energy += (2 * v[k] * v[k] + body.inertia_kg_m2[4 * k] * w[k] * w[k]) / 2;
      CHECK(energy < before + 1e-6);
      before = energy;
    }
    for (int k = 0; k < 3; ++k) CHECK(std::abs(it.v(1)[k]) + std::abs(it.w(1)[k]) < 1e-11);
  }
}
