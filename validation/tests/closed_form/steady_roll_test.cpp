// The steady roll of a coin, against Newton's and Euler's equations in world axes with the touch's force as an unknown.
#include <catch2/catch.hpp>

#include "scenes.hpp"
#include "validation/tests/catalogued.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

using Real = long double;
using Vec3 = std::array<Real, 3>;
Vec3 plus(const Vec3& a, Real s, const Vec3& b) { return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]}; }
Vec3 times(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Real along(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

struct Coin {
  Real m, g, R, l, I_a, I_t;
};
// a: its axis, pointing up; the turn about it does not matter
struct State {
  Vec3 p, a, w;
};

// v = rho x w keeps the touch at rest: v' = rho' x w + rho x w'. With F = m (v' + g z) at the touch,
//   (I w)' = rho x F,  I w = I_t w + (I_a - I_t)(a . w) a
// is linear in w'; its matrix comes column by column.
State rate(const Coin& c, const State& s) {
  const Vec3 z{0, 0, 1}, turned = times(s.w, s.a);
  const Real cosine = s.a[2], sine = std::sqrt(1 - cosine * cosine), sine_rate = -cosine * turned[2] / sine;
  const Vec3 down = plus({0, 0, 0}, -1 / sine, plus(z, -cosine, s.a));
  const Vec3 sunk = plus(plus({0, 0, 0}, cosine / sine, turned), turned[2] / sine, s.a);
  const Vec3 down_rate = plus(sunk, -sine_rate / sine, down);
  const Vec3 rho = plus(plus({0, 0, 0}, c.R, down), -c.l, s.a);
  const Vec3 rho_rate = plus(plus({0, 0, 0}, c.R, down_rate), -c.l, turned);
  const auto unbalanced = [&](const Vec3& w_rate) {  // (I w)' - rho x F
    const Real d = c.I_a - c.I_t, aw = along(s.a, s.w), aw_rate = along(turned, s.w) + along(s.a, w_rate);
    const Vec3 spun = plus(plus(plus({0, 0, 0}, c.I_t, w_rate), d * aw_rate, s.a), d * aw, turned);
    const Vec3 v_rate = plus(times(rho_rate, s.w), 1, times(rho, w_rate));
    return plus(spun, -c.m, times(rho, plus(v_rate, c.g, z)));
  };
  const Vec3 still = unbalanced({0, 0, 0});
  const Vec3 x = plus(unbalanced({1, 0, 0}), -1, still), y = plus(unbalanced({0, 1, 0}), -1, still),
             u = plus(unbalanced({0, 0, 1}), -1, still), right = plus({0, 0, 0}, -1, still);
  const Real determinant = along(x, times(y, u));
  const Vec3 w_rate{along(right, times(y, u)) / determinant, along(x, times(right, u)) / determinant,
                    along(x, times(y, right)) / determinant};
  return {times(rho, s.w), turned, w_rate};
}

State march(const Coin& c, State s, Real t_end_s, int steps) {
  const Real h = t_end_s / steps;
  const auto ahead = [&](const State& from, Real by, const State& k) {
    return State{plus(from.p, by, k.p), plus(from.a, by, k.a), plus(from.w, by, k.w)};
  };
  for (int n = 0; n < steps; ++n) {
    const State k1 = rate(c, s), k2 = rate(c, ahead(s, h / 2, k1)), k3 = rate(c, ahead(s, h / 2, k2)),
                k4 = rate(c, ahead(s, h, k3));
    s = ahead(ahead(ahead(ahead(s, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
  }
  return s;
}

Vec3 turned_by(const std::array<Wide, 4>& q, const Vec3& v) {
  const Vec3 u{Real(q[1]), Real(q[2]), Real(q[3])};
  return plus(v, 2, times(u, plus(times(u, v), Real(q[0]), v)));
}
Vec3 narrow(const std::array<Wide, 3>& v) { return {Real(v[0]), Real(v[1]), Real(v[2])}; }
Real apart(const Vec3& a, const Vec3& b) { return std::sqrt(along(plus(a, -1, b), plus(a, -1, b))); }

std::string refusal(const Scenario& scenario) {
  const Truth truth = closed_form_truth(scenario, 1);
  return truth.outcome.status == Status::unsupported ? truth.outcome.reason : "";
}

}  // namespace

TEST_CASE("steady-roll: coins go where Newton's and Euler's equations take their doubles, within the bar") {
  for (const std::string id : {"coin", "euler-disc"}) {
    const Scenario scenario = catalogued(id);
    const Truth truth = closed_form_truth(scenario, scenario.samples);
    INFO(id << ": " << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    const Body& body = scenario.scene.bodies[0];
    const Cylinder& shape = std::get<Cylinder>(body.shape);
    const Coin coin{body.mass_kg,          -scenario.scene.gravity_m_per_s2[2],
                    shape.radius_m,        shape.half_length_m,
                    body.inertia_kg_m2[8], body.inertia_kg_m2[0]};
    const BodySample &start = truth.values.front().bodies[0], &end = truth.values.back().bodies[0],
                     &bar = truth.bars.back().bodies[0];
    const State from{narrow(start.p_m), turned_by(start.q_wxyz, {0, 0, 1}),
                     turned_by(start.q_wxyz, narrow(start.w_rad_per_s))};
    const State to = march(coin, from, scenario.t_end_s, 100000);
    const Real p_bar = Real(bar.p_m[0]), q_bar = Real(bar.q_wxyz[0]), w_bar = Real(bar.w_rad_per_s[0]);
    CHECK(p_bar < 1e-12L);
    CHECK(w_bar < 1e-9L);
    CHECK(apart(to.p, narrow(end.p_m)) < 2 * p_bar);
    CHECK(apart(to.a, turned_by(end.q_wxyz, {0, 0, 1})) < 4 * q_bar);
    CHECK(apart(to.w, turned_by(end.q_wxyz, narrow(end.w_rad_per_s))) < 2 * w_bar);
  }
}

TEST_CASE("steady-roll: motions with nutation, slip or instability, and flat discs are refused with a reason") {
  Scenario nods = catalogued("coin");
  nods.scene.bodies[0].angular_velocity_body_rad_per_s[2] *= 1 + 1e-9;
  CHECK(refusal(nods).find("does not roll steadily") != std::string::npos);
  Scenario floats = catalogued("coin");
  floats.scene.bodies[0].position_m[2] += 1e-9;
  CHECK(refusal(floats).find("does not roll steadily") != std::string::npos);
  Scenario slips = catalogued("coin");
  for (PairLaw& pair : slips.scene.pairs) pair.friction = 0.3;
  CHECK(refusal(slips).find("it takes 0.325") != std::string::npos);
  Scenario falls = catalogued("coin");  // spins nearly upright, too slowly
  Body& coin = falls.scene.bodies[0];
  const double lean = 1.5, W = 8, R = 0.02, l = 0.001, m = 0.01, g = 9.81;
  const double sine = std::sin(lean), cosine = std::cos(lean), H = l * cosine + R * sine, x = R * cosine - l * sine;
  const double I_a = coin.inertia_kg_m2[8], I_t = coin.inertia_kg_m2[0];
  const double s = -(W * W * sine * cosine * (I_a - I_t) + m * x * (H * W * W + g)) / (W * (I_a * sine + m * H * R));
  coin.orientation_wxyz = {std::cos(lean / 2), 0, std::sin(lean / 2), 0};
  coin.angular_velocity_body_rad_per_s = {-W * sine, 0, s + W * cosine};
  coin.position_m = {-x - s * R / W, 0, H};
  coin.velocity_m_per_s = {0, -(W * x + s * R), 0};
  CHECK_THAT(refusal(falls), Catch::Contains("not stable"));
  Scenario flat = catalogued("coin");
  flat.scene.bodies[0].orientation_wxyz = {1, 0, 0, 0};
  CHECK(refusal(flat).find("does not lean") != std::string::npos);
  Scenario other = catalogued("coin");
  other.scene.bodies[0].inertia_kg_m2[0] *= 1.01;
  CHECK(refusal(other).find("not balanced") != std::string::npos);
}
