// Hyperbolas run for long, radial and nearly radial orbits, and what Kepler's equation cannot give: against the
// textbook's anomalies in 60 digits and more.
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

// An orbit in the plane from any state that is no parabola, by eccentric or hyperbolic anomaly. A perihelion at 1e-40
// of the distance takes 40 digits of the sum; no angular momentum at all is a case like others, up to the centre.
using Longer = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<160>>;
struct Orbit {
  Longer mu, r, eta, a, e, n, start;
  Longer x, y, vx, vy;

  Orbit(double mu_given, double x0, double y0, double vx0, double vy0) : mu(mu_given), x(x0), y(y0), vx(vx0), vy(vy0) {
    r = sqrt(x * x + y * y);
    eta = x * vx + y * vy;
    const Longer h = x * vy - y * vx;
    a = 1 / (2 / r - (vx * vx + vy * vy) / mu);  // negative: a hyperbola
    e = sqrt(1 - h * h / (mu * a));
    n = sqrt(mu / abs(a)) / abs(a);
    const Longer side = eta / sqrt(mu * abs(a));  // e sin E, or e sinh H
    start = a > 0 ? atan2(side, 1 - r / a) : asinh(side / e);
  }
  Longer mean(const Longer& anomaly) const { return a > 0 ? anomaly - e * sin(anomaly) : e * sinh(anomaly) - anomaly; }
  // Of a radial orbit: until the centre is reached; negative: it is not.
  Longer collision_s() const {
    if (a < 0) return mean(start) / -n;
    const Longer whole = 8 * atan(Longer(1));
    return (start > 0 ? whole - mean(start) : -mean(start)) / n;
  }
  // x, y, vx, vy at t
  std::array<Longer, 4> at(const Longer& t) const {
    const Longer M = mean(start) + n * t;
    Longer low = M - 2, high = M + 2;
    if (a < 0)
      for (high = 1, low = -1; mean(high) < M || mean(low) > M; low *= 2) high *= 2;
    for (int k = 0; k < 100; ++k) {
      const Longer middle = (low + high) / 2;
      (mean(middle) < M ? low : high) = middle;
    }
    for (int k = 0; k < 4; ++k) low -= (mean(low) - M) / (a > 0 ? 1 - e * cos(low) : e * cosh(low) - 1);
    const Longer d = low - start, size = abs(a), c = a > 0 ? cos(d) : cosh(d), s = a > 0 ? sin(d) : sinh(d);
    const Longer now = a > 0 ? a * (1 - e * cos(low)) : size * (e * cosh(low) - 1), turn = a > 0 ? 1 - c : c - 1;
    const Longer f = 1 - size / r * turn, g = t - (a > 0 ? d - s : s - d) / n, df = -sqrt(mu * size) * s / (now * r),
                 dg = 1 - size / now * turn;
    return {f * x + g * vx, f * y + g * vy, df * x + dg * vx, df * y + dg * vy};
  }
};

// The largest error of the samples, in bars; negative: there is none.
double worst_off(const Truth& truth, const Orbit& orbit, int body = 0) {
  double worst = -1;
  for (std::size_t k = 1; k < truth.values.size(); ++k) {
    const auto is = orbit.at(Longer(widened(truth.values[k].t_s)));
    const BodySample &value = truth.values[k].bodies[body], &bar = truth.bars[k].bodies[body];
    for (int i = 0; i < 2; ++i) {
      worst = std::max(worst, off(value.p_m[i], Long(is[i]), bar.p_m[i]));
      worst = std::max(worst, off(value.v_m_per_s[i], Long(is[2 + i]), bar.v_m_per_s[i]));
    }
  }
  return worst;
}

Scenario planet_at(double mu, double x, double y, double vx, double vy, double t_end_s) {
  Scenario given = scenario("kepler", t_end_s);
  given.scene.bodies = {point("planet", 1, {x, y, 0}, {vx, vy, 0})};
  given.scene.forces = {Attractor{{0}, {0, 0, 0}, mu}};
  return given;
}

double time_in(const std::string& reason) { return std::stod(reason.substr(reason.find(" at t = ") + 8)); }

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

TEST_CASE("Radial orbits are answered within their bars, up to the centre if they reach it") {
  struct Case {
    double mu, x, y, vx, vy, t_end_s;
  };
  for (const Case& c : {Case{1, 1, 0, 0, 0, 3},      // from rest
                        {1, 0.5, 0.25, 1, 0.5, 40},  // an ellipse, outwards and back
                        {1, 1, 0, -0.5, 0, 3},       // inwards
                        {1, 1, 0, 1.5, 0, 1e3},      // a hyperbola outwards
                        {1, 1, 0, 1.4142135623730954, 0, 1e9},
                        {1, 1, 0, 1.4142135623730947, 0, 1e6},
                        {1, 1, 0, 1e6, 0, 1e5},
                        {1, 1, 0, -1.5, 0, 2},
                        {1, -0.25, 1, 1e6, -4e6, 1},  // straight at the centre
                        {3e14, 7e6, 0, 0, 0, 1e5},
                        {1e-9, 0, 1e-3, 0, -1e-3, 20}}) {
    const Orbit orbit(c.mu, c.x, c.y, c.vx, c.vy);
    const auto end_s = static_cast<double>(orbit.collision_s());
    const bool collides = end_s > 0 && end_s < c.t_end_s;
    for (const double share :
         {1.0, 0.999999}) {  // of the time to the collision: the second has a sample just before it
      const double t_end_s = collides && share < 1 ? end_s * share : c.t_end_s;
      const Truth truth = closed_form_truth(planet_at(c.mu, c.x, c.y, c.vx, c.vy, t_end_s), 20);
      INFO("mu " << c.mu << ", x " << c.x << ", vx " << c.vx << ", until " << t_end_s << ": " << truth.outcome.reason);
      CHECK(truth.outcome.status == (collides && share == 1 ? Status::unsupported : Status::ok));
      if (collides && share == 1) {
        CHECK_THAT(truth.outcome.reason, Catch::Contains("`planet` reaches the centre of attraction at t = "));
        CHECK(std::abs(time_in(truth.outcome.reason) / end_s - 1) < 1e-14);
        CHECK(static_cast<int>(truth.values.size()) == 1 + static_cast<int>(20 * end_s / c.t_end_s));
      } else {
        CHECK(truth.values.size() == 21);
      }
      CHECK(worst_off(truth, orbit) < 1);
      if (truth.bars.size() > 1)
        CHECK(static_cast<double>(truth.bars.back().bodies[0].p_m[0]) < 1e-15 * t_end_s * orbit.r);
    }
  }
}

TEST_CASE("The radial parabola: r^(3/2) grows by sqrt(9 mu / 2) t") {
  for (const double v : {2.0, -2.0}) {
    const Truth truth = closed_form_truth(planet_at(2, 1, 0, v, 0, 4), 64);
    CHECK(truth.outcome.status == (v > 0 ? Status::ok : Status::unsupported));
    CHECK(truth.values.size() == (v > 0 ? 65 : 6));  // the collision is at t = 1/3
    for (std::size_t k = 1; k < truth.values.size(); ++k) {
      const Long t = widened(truth.values[k].t_s), s = v > 0 ? 1 : -1, r = pow(1 + s * 3 * t, Long(2) / 3);
      CHECK(off(truth.values[k].bodies[0].p_m[0], r, truth.bars[k].bodies[0].p_m[0]) < 1);
      CHECK(off(truth.values[k].bodies[0].v_m_per_s[0], s * 2 / sqrt(r), truth.bars[k].bodies[0].v_m_per_s[0]) < 1);
    }
  }
}

TEST_CASE("An angular momentum of 1e-10 and 1e-20 of the scale turns round the centre, within the bars") {
  for (const double across : {1e-10, 1e-20, 1e-40, 1e-200})
    for (const double vx : {0.0, 0.5, -0.5, 1.4142135623730951, -1.4142135623730951, 1.5, -1.5, -20.0})
      for (const double t_end_s : {2.5, 40.0}) {
        const Truth truth = closed_form_truth(planet_at(1, 1, 0, vx, across, t_end_s), 10);
        INFO("across " << across << ", vx " << vx << ", until " << t_end_s << ": " << truth.outcome.reason);
        REQUIRE(truth.outcome.status == Status::ok);
        CHECK(worst_off(truth, Orbit(1, 1, 0, vx, across)) < 1);
      }
}

TEST_CASE("A truth of many samples ends at the collision, too, and names both bodies of a pair") {
  Scenario given = charges(1, -1, 4);
  given.scene.bodies.push_back(point("bystander", 1, {5, 5, 5}, {1, 0, 0}));
  const Truth truth = closed_form_truth(given, 20000);
  CHECK(truth.outcome.status == Status::unsupported);
  CHECK_THAT(truth.outcome.reason, Catch::Contains("`a` and `b` collide at t = 0.785398163397448"));  // pi / 4
  CHECK(truth.values.size() == 3927);
  CHECK(truth.bars.size() == 3927);
  given.t_end_s = 1.0;
  CHECK(closed_form_truth(given, 20000).values.size() == 15708);
  given.t_end_s = 0.75;
  const Truth fall = closed_form_truth(given, 64);
  REQUIRE(fall.outcome.reason == "");
  CHECK(std::abs(static_cast<double>(fall.values.back().bodies[0].p_m[0] + fall.values.back().bodies[1].p_m[0]) - 1) <
        1e-30);
}

TEST_CASE("Whether an orbit is radial follows from the scene's numbers in exact arithmetic") {
  Scenario given = charges(1, -1, 4);
  // Products of the differences need more digits than quad has: 1 part in 2^120 across.
  const double tiny = 0x1p-60;
  given.scene.bodies[0].position_m = {-tiny, -tiny, 0};
  given.scene.bodies[1].position_m = {1, 1, 0};
  given.scene.bodies[0].velocity_m_per_s = {tiny, tiny, 0};
  given.scene.bodies[1].velocity_m_per_s = {-1, -1, 0};
  CHECK_THAT(closed_form_truth(given, 4).outcome.reason, Catch::Contains("collide at t = "));
  given.scene.bodies[1].velocity_m_per_s[2] = 0x1p-400;
  CHECK(closed_form_truth(given, 4).outcome.reason == "");
}

TEST_CASE("Charges without interaction move on straight lines, also through each other") {
  Scenario given = charges(1, 0, 8);
  given.scene.bodies[1].velocity_m_per_s = {-0.5, 0, 0};
  const Truth truth = closed_form_truth(given, 8);
  REQUIRE(truth.outcome.reason == "");
  CHECK(truth.values.back().bodies[1].p_m[0] == Wide(-3));
}

TEST_CASE("A motion that magnifies round-off past all kDigits is refused, not given a bar") {
  // A close ellipse for 1e22 of its periods: the phase is lost in long double, and nearly so in quad.
  const Truth lost = closed_form_truth(planet(1, 1, 1.1, 1e23), 4);
  CHECK(lost.outcome.status == Status::unsupported);
  CHECK_THAT(lost.outcome.reason, Catch::Contains("amplifies round-off"));
}
