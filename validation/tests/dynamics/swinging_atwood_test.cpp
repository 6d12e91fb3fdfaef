// The second invariant of the swinging Atwood machine along solutions of its two equations of motion in polar
// coordinates, (M + m) r'' = m r th'^2 + m g cos th - M g and r th'' = -g sin th - 2 r' th', stepped here by RK4 in
// long double.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "dynamics/invariants.hpp"
#include "dynamics/swinging_atwood.hpp"

using namespace atwood;
using namespace atwood::dynamics;

namespace {

using State = std::array<long double, 4>;  // r, th, r', th'
constexpr long double kG = 9.81L;

State rate(const State& y, long double ratio) {
  const auto& [r, th, v, w] = y;
  return {v, w, (r * w * w + kG * std::cos(th) - ratio * kG) / (1 + ratio), (-kG * std::sin(th) - 2 * v * w) / r};
}

State plus(const State& y, long double h, const State& k) {
  State z = y;
  for (std::size_t i = 0; i < 4; ++i) z[i] += h * k[i];
  return z;
}

State after(State y, long double t, int steps, long double ratio) {
  const long double h = t / steps;
  for (int n = 0; n < steps; ++n) {
    const State a = rate(y, ratio), b = rate(plus(y, h / 2, a), ratio), c = rate(plus(y, h / 2, b), ratio),
                d = rate(plus(y, h, c), ratio);
    for (std::size_t i = 0; i < 4; ++i) y[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
  return y;
}

// Gravity along -z; the plane of the bob is turned about the vertical; the bob's point is not at the origin.
constexpr Real3 kPoint{0.5, -0.25, 2}, kOther{-1, 0.5, 2}, kSide{0.6, 0.8, 0};

Scene machine(double mass, double heavy, const State& y) {
  Scene scene;
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  scene.bodies.resize(2);
  scene.bodies[0].mass_kg = mass, scene.bodies[1].mass_kg = heavy;
  for (int i = 0; i < 3; ++i)
    scene.bodies[0].position_m[i] =
        kPoint[i] + static_cast<double>(y[0]) * (std::sin(static_cast<double>(y[1])) * kSide[i] -
                                                 (i == 2) * std::cos(static_cast<double>(y[1])));
  scene.bodies[1].position_m = {kOther[0], kOther[1], 1};
  Rope rope;
  rope.bodies = {0, 1};
  rope.over.resize(2);
  rope.over[0].axle_m = kPoint, rope.over[1].axle_m = kOther;
  scene.ropes = {rope};
  return scene;
}

Sample sample_of(const State& y) {
  Sample sample;
  sample.bodies.resize(2);
  const long double s = std::sin(y[1]), c = std::cos(y[1]);
  for (std::size_t i = 0; i < 3; ++i) {
    const long double out = kSide[i], up = i == 2 ? 1 : 0;
    sample.bodies[0].p_m[i] = kPoint[i] + y[0] * (s * out - c * up);
    sample.bodies[0].v_m_per_s[i] = y[2] * (s * out - c * up) + y[0] * y[3] * (c * out + s * up);
  }
  return sample;
}

}  // namespace

TEST_CASE("the swinging Atwood machine's second invariant stays, through whole turns of the bob") {
  for (const long double start : {1.0L, 1.5L}) {  // the second passes -2 pi
    const State y0{1, start, 0, 0};
    const Scene scene = machine(1, 3, y0);
    REQUIRE(conserves(scene, "swinging-atwood"));
    const SwingingAtwood first = swinging_atwood(scene, sample_of(y0));
    // At rest only g r^2 sin(th/2) cos^2(th/2) is left.
    const long double half = start / 2;
    CHECK(static_cast<double>(first.invariant) ==
          Approx(static_cast<double>(kG * std::sin(half) * std::cos(half) * std::cos(half))).epsilon(1e-14));
    for (int k = 1; k <= 10; ++k) {
      const SwingingAtwood now = swinging_atwood(scene, sample_of(after(y0, 0.5L * k, 8000 * k, 3)));
      CHECK(std::fabs(static_cast<double>((now.invariant - first.invariant) / now.size)) < 1e-11);
    }
    // With another counterweight it is not constant.
    const SwingingAtwood other = swinging_atwood(scene, sample_of(after(y0, 1, 8000, 2.5L)));
    CHECK(std::fabs(static_cast<double>((other.invariant - first.invariant) / other.size)) > 1e-3);
  }
}

TEST_CASE("which scenes are a swinging Atwood machine of the ratio 3") {
  const Scene machine_3 = machine(1, 3, {1, 1, 0, 0});
  CHECK(is_swinging_atwood_machine(machine_3));
  CHECK_FALSE(is_swinging_atwood_machine(machine(1, 2.5, {1, 1, 0, 0})));
  CHECK(conserves(machine_3, "energy"));
  Scene scene = machine_3;
  scene.ropes[0].over[0].radius_m = 0.1;
  CHECK_FALSE(is_swinging_atwood_machine(scene));
  scene = machine_3;
  scene.bodies[1].position_m[0] += 1e-3;
  CHECK_FALSE(is_swinging_atwood_machine(scene));
  scene = machine_3;
  scene.bodies[0].velocity_m_per_s = {0.8, -0.6, 0};  // out of its plane
  CHECK_FALSE(is_swinging_atwood_machine(scene));
  scene.bodies[0].velocity_m_per_s = {0.6, 0.8, 0.5};
  CHECK(is_swinging_atwood_machine(scene));
  scene.ropes[0].points_body_m[0] = {0, 0, 0.1};
  CHECK_FALSE(is_swinging_atwood_machine(scene));
}
