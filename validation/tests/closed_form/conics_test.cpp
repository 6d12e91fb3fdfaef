// Hyperbolas run for long, radial ones, and what Kepler's equation cannot give: against the textbook's anomalies in 60
// digits.
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <catch2/catch.hpp>

#include "scenes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

using Long = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<60>>;

Long widened(Wide x) {  // exact: two parts of 57 and 56 bits, each in two doubles
  Long sum = 0;
  for (int k = 0; k < 4; ++k) {
    const double part = static_cast<double>(x);
    sum += part;
    x -= part;
  }
  return sum;
}

double off(Wide value, const Long& exact, Wide bar) {  // in bars
  return static_cast<double>(abs(widened(value) - exact) / widened(bar));
}

// From the perihelion at (r, 0), v along y: M = sqrt(mu / a^3) t = e sinh H - H, by bisection and Newton.
struct Far {
  Long x, y, vx, vy;
};
Far hyperbola(double mu, double r, double v, double t) {
  const Long m = mu, b = Long(v) * v - 2 * m / r, a = m / b, e = 1 + r / a, n = sqrt(b) / a, M = n * t;
  Long low = 0, high = 1;
  while (e * sinh(high) - high < M) high *= 2;
  for (int k = 0; k < 300; ++k) {
    const Long middle = (low + high) / 2;
    (e * sinh(middle) - middle < M ? low : high) = middle;
  }
  const Long H = low, rate = n / (e * cosh(H) - 1), across = a * sqrt(e * e - 1);
  return {a * (e - cosh(H)), across * sinh(H), -a * sinh(H) * rate, across * cosh(H) * rate};
}

Scenario planet(double mu, double r, double v, double t_end_s) {
  Scenario given = scenario("kepler", t_end_s);
  given.scene.bodies = {point("planet", 1, {r, 0, 0}, {0, v, 0})};
  given.scene.forces = {Attractor{{0}, {0, 0, 0}, mu}};
  return given;
}

Scenario charges(double distance, double q, double t_end_s) {
  Scenario given = scenario("coulomb-two-body", t_end_s);
  given.scene.bodies = {point("a", 1, {0, 0, 0}, {0, 0, 0}), point("b", 1, {distance, 0, 0}, {0, 0, 0})};
  given.scene.bodies[0].charge_C = q;
  given.scene.bodies[1].charge_C = 1;
  given.scene.forces = {Coulomb{{0, 1}, 1}};
  return given;
}

}  // namespace

TEST_CASE("Hyperbolas stay within their bars however long they run") {
  struct Case {
    double mu, r, v, t;
  };
  for (const Case& c : {Case{1, 1, 5, 1000},
                        {1, 1, 5, 1e12},
                        {1, 1, 1.5, 1e6},
                        {2, 0.01, 300, 1e4},
                        {1, 1e6, 3, 1e9},
                        {1e14, 7e6, 2e4, 1e10},
                        {1e-9, 1e-3, 1, 1e5},
                        {1, 1, 1e6, 1e5},
                        {1, 1, 1.4142135623730954, 1e9},
                        {1, 1, 5, 1e200}}) {
    const Truth truth = closed_form_truth(planet(c.mu, c.r, c.v, c.t), 4);
    INFO("mu " << c.mu << ", r " << c.r << ", v " << c.v << ", t " << c.t << ": " << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    const BodySample &end = truth.values.back().bodies[0], &bar = truth.bars.back().bodies[0];
    const Far exact = hyperbola(c.mu, c.r, c.v, c.t);
    CHECK(off(end.p_m[0], exact.x, bar.p_m[0]) < 1);
    CHECK(off(end.p_m[1], exact.y, bar.p_m[1]) < 1);
    CHECK(off(end.v_m_per_s[0], exact.vx, bar.v_m_per_s[0]) < 1);
    CHECK(off(end.v_m_per_s[1], exact.vy, bar.v_m_per_s[1]) < 1);
    CHECK(static_cast<double>(bar.v_m_per_s[0]) < 1e-20 * c.v);
  }
}

TEST_CASE("Like charges from rest: t = sqrt(r0^3 / 2 mu) (sqrt(x (x - 1)) + log(sqrt x + sqrt(x - 1))), x = r / r0") {
  for (const double t : {1e-3, 1.0, 1e3, 1e6, 1e12, 1e100})
    for (const double r0 : {1.0, 1e-6, 1e6}) {
      const Truth truth = closed_form_truth(charges(r0, 1, t), 2);
      INFO("t " << t << ", r0 " << r0 << ": " << truth.outcome.reason);
      REQUIRE(truth.outcome.status == Status::ok);
      const auto &bodies = truth.values.back().bodies, &bars = truth.bars.back().bodies;
      const Long r = widened(bodies[1].p_m[0]) - widened(bodies[0].p_m[0]), x = r / r0, mu = 2;
      const Long start = r0, scale = sqrt(start * start * start / (2 * mu));
      const Long late = scale * (sqrt(x * (x - 1)) + log(sqrt(x) + sqrt(x - 1))) - t;
      const Long speed = sqrt(2 * mu * (1 / start - 1 / r)),
                 allowed = widened(bars[0].p_m[0]) + widened(bars[1].p_m[0]);
      CHECK(abs(late * speed) < allowed);
      if (x > 2) CHECK(abs(widened(bodies[1].v_m_per_s[0]) - speed / 2) < widened(bars[1].v_m_per_s[0]));
    }
}

TEST_CASE(
    "Charges without interaction move on straight lines, also through each other; unlike charges from rest are refused") {
  Scenario given = charges(1, 0, 8);
  given.scene.bodies[1].velocity_m_per_s = {-0.5, 0, 0};
  const Truth truth = closed_form_truth(given, 8);
  REQUIRE(truth.outcome.reason == "");
  CHECK(truth.values.back().bodies[1].p_m[0] == Wide(-3));
  CHECK(closed_form_truth(charges(1, -1, 8), 8).outcome.status == Status::unsupported);
}

TEST_CASE("A motion that magnifies round-off past all kDigits is refused, not given a bar") {
  // A close ellipse for 1e22 of its periods: the phase is lost in long double, and nearly so in quad.
  const Truth lost = closed_form_truth(planet(1, 1, 1.1, 1e23), 4);
  CHECK(lost.outcome.status == Status::unsupported);
  CHECK_THAT(lost.outcome.reason, Catch::Contains("amplifies round-off"));
}
