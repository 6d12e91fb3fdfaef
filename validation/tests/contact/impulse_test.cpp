// The impulse at a point against closed forms and conservation laws.
#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include "contact/impulse.hpp"
#include "contact/slip_path.hpp"

using namespace atwood;
using V = Vec3<double>;

namespace {

ImpactBody<double> body(double mass_kg, const V& I_kg_m2, const V& r_W, const V& v_W, const V& w_W) {
  ImpactBody<double> b;
  b.inverse_mass_per_kg = 1 / mass_kg;
  b.I_inverse_W_row[0] = {1 / I_kg_m2.x, 0, 0};
  b.I_inverse_W_row[1] = {0, 1 / I_kg_m2.y, 0};
  b.I_inverse_W_row[2] = {0, 0, 1 / I_kg_m2.z};
  b.r_W = r_W;
  b.v_W = v_W;
  b.w_W = w_W;
  return b;
}

ImpactBody<double> wall(const V& r_W) {
  ImpactBody<double> b;
  b.r_W = r_W;
  return b;
}

double kinetic(const ImpactBody<double>& b, double mass_kg, const V& I) {
  return 0.5 * mass_kg * dot(b.v_W, b.v_W) +
         0.5 * (I.x * b.w_W.x * b.w_W.x + I.y * b.w_W.y * b.w_W.y + I.z * b.w_W.z * b.w_W.z);
}

}  // namespace

TEST_CASE("a rod struck at its end: linear and angular impulse of the closed form") {
  // J = (1 + e) u / (1/m + d^2 / I) for a rod at rest met at distance d from its centre by a wall that moves with u.
  const double m = 1.2, I = 0.08, d = 0.4, u = 3, e = 0.6;
  auto rod = body(m, {I, I, 0.01}, {0, 0, d}, {0, 0, 0}, {0, 0, 0});
  auto hammer = wall({0, 0, 0});
  hammer.v_W = {u, 0, 0};
  const auto impulse = collide<double>({e, 0}, {1, 0, 0}, hammer, rod);
  const double J = (1 + e) * u / (1 / m + d * d / I);
  CHECK(impulse.normal_N_s == Approx(J).epsilon(1e-14));
  CHECK(rod.v_W.x == Approx(J / m).epsilon(1e-14));
  CHECK(rod.w_W.y == Approx(d * J / I).epsilon(1e-14));  // r x J = (0, 0, d) x (J, 0, 0) = (0, d J, 0)
  CHECK(impulse.vn_after_m_per_s == Approx(e * u).epsilon(1e-14));
}

TEST_CASE("inertia far below 1 kg m^2 is used as it is") {
  const double m = 0.1, I = 4e-6, d = 0.01;
  auto small = body(m, {I, I, I}, {0, 0, d}, {-1, 0, 0}, {0, 0, 0});
  auto fixed = wall({0, 0, 0});
  const auto impulse = collide<double>({1, 0}, {1, 0, 0}, fixed, small);
  CHECK(impulse.normal_N_s == Approx(2 / (1 / m + d * d / I)).epsilon(1e-14));
  CHECK(std::abs(small.w_W.y) > 100);
}

TEST_CASE("random impacts conserve momentum and angular momentum, with e = 1 energy, and have the given restitution") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  auto vector = [&] { return V{any(random), any(random), any(random)}; };
  int met = 0;
  for (int i = 0; i < 2000; ++i) {
    const double m1 = 1.5 + any(random), m2 = 1.5 + any(random), e = i % 2 == 0 ? 1 : 0.5 * (1 + any(random));
    const V I1{1.1 + any(random), 1.2, 1.3}, I2{0.2, 0.3 + 0.1 * any(random), 0.25};
    V n = vector();
    n = (1 / norm(n)) * n;
    const V point = vector(), p1 = vector(), p2 = vector();
    auto a = body(m1, I1, point - p1, vector(), vector());
    auto b = body(m2, I2, point - p2, vector(), vector());
    const auto a0 = a, b0 = b;
    const auto impulse = collide<double>({e, 0}, n, a, b);
    if (!(impulse.vn_before_m_per_s < 0)) continue;
    ++met;
    const V dp1 = m1 * (a.v_W - a0.v_W), dp2 = m2 * (b.v_W - b0.v_W);
    CHECK(norm(dp1 + dp2) < 1e-13);
    auto spin = [](const V& I, const V& w) { return V{I.x * w.x, I.y * w.y, I.z * w.z}; };
    const V dL = spin(I1, a.w_W - a0.w_W) + spin(I2, b.w_W - b0.w_W) + cross(p1, dp1) + cross(p2, dp2);
    CHECK(norm(dL) < 1e-13);
    CHECK(impulse.vn_after_m_per_s == Approx(-e * impulse.vn_before_m_per_s).epsilon(1e-12).margin(1e-14));
    const double before = kinetic(a0, m1, I1) + kinetic(b0, m2, I2), after = kinetic(a, m1, I1) + kinetic(b, m2, I2);
    if (e == 1) CHECK(after == Approx(before).epsilon(1e-13));
    else CHECK(after < before);
  }
  CHECK(met > 500);
}

TEST_CASE("a ball on a rough floor: slip stays on the cone, stick stops the slip") {
  const double m = 2, r = 0.1, I = 0.4 * m * r * r, vz = -3, vx = 5, e = 0.8;
  auto ball = body(m, {I, I, I}, {0, 0, -r}, {vx, 0, vz}, {0, 0, 0});
  auto floor = wall({0, 0, 0});
  SECTION("slip: mu small") {
    const double mu = 0.1, J = m * (1 + e) * -vz;
    const auto impulse = collide<double>({e, mu}, {0, 0, 1}, floor, ball);
    CHECK(impulse.tangential_N_s == Approx(mu * J).epsilon(1e-14));
    CHECK(ball.v_W.x == Approx(vx - mu * J / m).epsilon(1e-14));
    CHECK(ball.w_W.y == Approx(r * mu * J / I).epsilon(1e-14));
  }
  SECTION("stick: mu large; rolls with 5/7 of its speed") {
    collide<double>({e, 10}, {0, 0, 1}, floor, ball);
    CHECK(ball.v_W.x == Approx(vx * 5 / 7).epsilon(1e-14));
    CHECK(ball.w_W.y == Approx(ball.v_W.x / r).epsilon(1e-14));
  }
}

TEST_CASE("the slip path reports its iterations, and one that has no end is capped") {
  const ImpactLaw<double> law{0.5, 0.3, 0, Restitution::newton};
  const double u0[3] = {1, 0, -1};
  const double turning[3][3] = {{2, 0.3, 0.4}, {0.3, 1.5, 0.2}, {0.4, 0.2, 1}};
  const SlipPath<double> path = slip_path(law, turning, u0);
  CHECK(path.solve.ended == SolveEnd::converged);
  CHECK(path.solve.iterations > 0);
  // Not positive definite, which no masses give: the normal velocity falls for ever.
  const double falling[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  const SlipPath<double> endless = slip_path(law, falling, u0);
  CHECK(endless.solve.ended == SolveEnd::capped);
  CHECK(std::isinf(endless.solve.residual));
}
