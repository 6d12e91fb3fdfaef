// The certified solvers against reference values: first from exact decimals in quad, to the last digit that the values
// stand for; then the truths of the scenes (whose decimals are rounded to double), to what that rounding explains.
#include "reference_values.hpp"

#include <quadmath.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <type_traits>

#include "extended/collocation.hpp"
#include "extended/extended.hpp"
#include "extended/extrapolation.hpp"
#include "scenes.hpp"

using namespace atwood;
using namespace atwood::extended;

namespace {

Wide decimal(const char* text) { return strtoflt128(text, nullptr); }
double root(double x) { return std::sqrt(x); }
Wide root(Wide x) { return sqrtq(x); }
double sine(double x) { return std::sin(x); }
Wide sine(Wide x) { return sinq(x); }
template <class Y> using Scalar = std::remove_cvref_t<decltype(*std::declval<Y>())>;

std::vector<Wide> decimals(const std::vector<const char*>& texts) {
  std::vector<Wide> made;
  for (const char* text : texts) made.push_back(decimal(text));
  return made;
}

double distance(const std::vector<Wide>& y, const std::vector<const char*>& expected) {
  double largest = 0;
  for (std::size_t i = 0; i < expected.size(); ++i)
    largest = std::max(largest, static_cast<double>(fabsq(y[i] - decimal(expected[i]))));
  return largest;
}

std::vector<Wide> solve(const Problem& problem, std::vector<Wide> y, Wide span, bool gauss, double tolerance) {
  std::unique_ptr<Stepper<Wide>> stepper;
  if (gauss) stepper = std::make_unique<Collocation>(problem, tolerance);
  else stepper = std::make_unique<Extrapolation<Wide>>(problem.size, problem.group, problem.rate, tolerance);
  REQUIRE(advance<Wide>(*stepper, 0, y.data(), span));
  return y;
}

// Both methods reproduce the values to the difference stated for them plus the methods' own difference here, which must
// be of that order itself; 1e-30 of the values' size is the round-off of a run in quad.
void reproduces(const Problem& problem, const std::vector<const char*>& initial, const char* span,
                const reference_values::Values& expected, double tolerance = 1e-29) {
  double size = 0, own = 0;
  for (const char* text : expected.at_end) size = std::max(size, std::fabs(static_cast<double>(decimal(text))));
  const std::vector<Wide> ends[] = {solve(problem, decimals(initial), decimal(span), false, tolerance),
                                    solve(problem, decimals(initial), decimal(span), true, tolerance)};
  for (std::size_t i = 0; i < ends[0].size(); ++i)
    own = std::max(own, static_cast<double>(fabsq(ends[0][i] - ends[1][i])));
  CHECK(own <= 2 * expected.difference + 1e-30 * size);
  for (const auto& end : ends) {
    const double off = distance(end, expected.at_end);
    INFO((&end == ends ? "extrapolation" : "collocation")
         << " is off by " << off << ", stated " << expected.difference << ", own difference " << own);
    CHECK(off <= expected.difference + own + 1e-30 * size);
  }
}

// n bodies in the plane or in space: y = (all of axis 1, all of axis 2, ..., then velocities alike), or body by body.
template <class Y, class D> void attract(int n, int axes, bool by_body, const std::vector<Wide>& pull, Y y, D dydt) {
  using S = Scalar<Y>;
  const auto at = [&](int body, int axis) { return by_body ? body * axes + axis : axis * n + body; };
  const int half = n * axes;
  for (int i = 0; i < half; ++i) {
    dydt[i] = y[half + i];
    dydt[half + i] = 0;
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) {
      S square = 0;
      for (int axis = 0; axis < axes; ++axis) {
        const S d = y[at(j, axis)] - y[at(i, axis)];
        square += d * d;
      }
      const S weight = 1 / (square * root(square));
      for (int axis = 0; axis < axes; ++axis) {
        const S d = y[at(j, axis)] - y[at(i, axis)];
        dydt[half + at(i, axis)] += static_cast<S>(pull[j]) * weight * d;
        dydt[half + at(j, axis)] -= static_cast<S>(pull[i]) * weight * d;
      }
    }
}

Problem three_body() {
  const Wide mu = decimal("0.012277471");
  return problem_of(4, [mu](auto, const auto* y, auto* dydt) {
    using S = Scalar<decltype(y)>;
    const S m = static_cast<S>(mu), k = static_cast<S>(1 - mu);
    const S a = (y[0] + m) * (y[0] + m) + y[1] * y[1], b = (y[0] - k) * (y[0] - k) + y[1] * y[1];
    const S A = a * root(a), B = b * root(b);
    dydt[0] = y[2];
    dydt[1] = y[3];
    dydt[2] = y[0] + 2 * y[3] - k * (y[0] + m) / A - m * (y[0] - k) / B;
    dydt[3] = y[1] - 2 * y[2] - k * y[1] / A - m * y[1] / B;
  });
}

// L' = L x w, w = I^-1 L; q' = 1/2 q (0, w).
Problem free_top() {
  const Wide third = decimal("0.6"), second = decimal("0.8");
  return problem_of(7, [third, second](auto, const auto* y, auto* dydt) {
    using S = Scalar<decltype(y)>;
    const S w[3] = {y[0] / static_cast<S>(third), y[1] / static_cast<S>(second), y[2]};
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3, m = (k + 2) % 3;
      dydt[k] = y[l] * w[m] - y[m] * w[l];
    }
    const auto* q = y + 3;
    dydt[3] = -(q[1] * w[0] + q[2] * w[1] + q[3] * w[2]) / 2;
    dydt[4] = (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]) / 2;
    dydt[5] = (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]) / 2;
    dydt[6] = (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]) / 2;
  });
}

Problem convection() {
  return problem_of(3, [](auto, const auto* y, auto* dydt) {
    dydt[0] = 10 * (y[1] - y[0]);
    dydt[1] = y[0] * (28 - y[2]) - y[1];
    dydt[2] = y[0] * y[1] - 8 * y[2] / 3;
  });
}

Problem galaxy() {
  return problem_of(4, [](auto, const auto* y, auto* dydt) {
    dydt[0] = y[2];
    dydt[1] = y[3];
    dydt[2] = -y[0] - 2 * y[0] * y[1];
    dydt[3] = -y[1] - y[0] * y[0] + y[1] * y[1];
  });
}

const std::vector<const char*> pleiades_start{"3",    "3", "-1", "-3", "2",     "-2", "2", "3", "-3", "2",
                                              "0",    "0", "-4", "4",  "0",     "0",  "0", "0", "0",  "1.75",
                                              "-1.5", "0", "0",  "0",  "-1.25", "1",  "0", "0"};

}  // namespace

TEST_CASE("from exact decimals: orbits") {
  reproduces(problem_of(28,
                        [](auto, const auto* y, auto* d) {
                          attract(7, 2, false, {1, 2, 3, 4, 5, 6, 7}, y, d);
                        }),
             pleiades_start, "3", reference_values::pleiades, 1e-26);
  reproduces(three_body(), {"0.994", "0", "0", "-2.00158510637908252240537862224"}, "17.0652165601579625588917206249",
             reference_values::arenstorf);
  reproduces(three_body(), {"0.994", "0", "0", "-2.0317326295573368357302057924"}, "11.124340337266085134999734047",
             reference_values::arenstorf_small);
  const Problem kepler = problem_of(4, [](auto, const auto* y, auto* dydt) {
    using S = Scalar<decltype(y)>;
    const S square = y[0] * y[0] + y[1] * y[1], weight = 1 / (square * root(square));
    dydt[0] = y[2];
    dydt[1] = y[3];
    dydt[2] = -weight * y[0];
    dydt[3] = -weight * y[1];
  });
  reproduces(kepler, {"0.4", "0", "0", "2"}, "50", reference_values::kepler_50);
  reproduces(kepler, {"0.4", "0", "0", "2"}, "10", {reference_values::kepler_10.at_end, 1e-28}, 1e-31);
}

TEST_CASE("from exact decimals: the outer solar system over 200000 days") {
  std::vector<Wide> pull;
  for (const char* mass : {"1", "0.000954786104043", "0.000285583733151", "0.0000437273164546", "0.0000517759138449"})
    pull.push_back(decimal("2.95912208286e-4") * decimal(mass));
  pull.push_back(decimal("2.95912208286e-4") / decimal("1.3e8"));
  Problem problem = problem_of(36, [pull](auto, const auto* y, auto* d) { attract(6, 3, true, pull, y, d); });
  problem.group.assign(36, 0);
  std::fill(problem.group.begin() + 18, problem.group.end(), 1);
  reproduces(problem, {"0",          "0",           "0",           "-3.5023653",  "-3.8169847",  "-1.5507963",
                       "9.0755314",  "-3.0458353",  "-1.6483708",  "8.3101420",   "-16.2901086", "-7.2521278",
                       "11.4707666", "-25.7294829", "-10.8169456", "-15.5387357", "-25.2225594", "-3.1902382",
                       "0",          "0",           "0",           "0.00565429",  "-0.00412490", "-0.00190589",
                       "0.00168318", "0.00483525",  "0.00192462",  "0.00354178",  "0.00137102",  "0.00055029",
                       "0.00288930", "0.00114527",  "0.00039677",  "0.00276725",  "-0.00170702", "-0.00136504"},
             "200000", reference_values::outer_solar_system, 1e-31);
}

TEST_CASE("from exact decimals: the figure-eight closes") {
  using namespace reference_values;
  const Wide vx = decimal(figure_eight_vx), vy = decimal(figure_eight_vy);
  const Wide x = decimal(figure_eight_x), y = decimal(figure_eight_y);
  const std::vector<Wide> start{x, y, -x, -y, 0, 0, -vx / 2, -vy / 2, -vx / 2, -vy / 2, vx, vy};
  const Problem problem = problem_of(12, [](auto, const auto* s, auto* d) { attract(3, 2, true, {1, 1, 1}, s, d); });
  for (const bool gauss : {false, true}) {
    const std::vector<Wide> end = solve(problem, start, decimal(figure_eight_period), gauss, 1e-30);
    double off = 0;
    for (int i = 0; i < 12; ++i) off = std::max(off, static_cast<double>(fabsq(end[i] - start[i])));
    CHECK(off < 10 * figure_eight_closure);
  }
}

TEST_CASE("from exact decimals: potentials, chaos, rotation") {
  reproduces(galaxy(), {"0.1", "0", "0", "0.5"}, "10", reference_values::henon_heiles_10, 1e-30);
  reproduces(galaxy(), {"0.1", "0", "0", "0.5"}, "100", reference_values::henon_heiles_100, 1e-30);
  reproduces(convection(), {"1", "0", "0"}, "1", reference_values::lorenz_1, 1e-30);
  reproduces(convection(), {"1", "0", "0"}, "5", reference_values::lorenz_5, 1e-30);
  reproduces(convection(), {"1", "0", "0"}, "10", reference_values::lorenz_10, 1e-30);
  reproduces(free_top(), {"1.8", "0.4", "-0.9", "1", "0", "0", "0"}, "10", reference_values::asymmetric_top, 1e-30);
  reproduces(free_top(), {"0.0006", "0.8", "0.001", "1", "0", "0", "0"}, "100", reference_values::dzhanibekov, 1e-30);
  reproduces(problem_of(3,
                        [](auto, const auto* y, auto* dydt) {
                          dydt[0] = -2 * y[1] * y[2];
                          dydt[1] = 5 * y[0] * y[2] / 4;
                          dydt[2] = -y[0] * y[1] / 2;
                        }),
             {"1", "0", "0.9"}, "20", reference_values::rigid_body_20, 1e-30);
  reproduces(problem_of(2,
                        [](auto, const auto* y, auto* dydt) {
                          dydt[0] = y[1];
                          dydt[1] = -sine(y[0]);
                        }),
             {"1.57079632679489661923132169163975144", "0"}, "10", reference_values::pendulum_10, 1e-30);
}

namespace {

// The scene is the problem after rounding to double; the values belong to the decimals. Data that are off by half an
// ulp (1.1e-16 relative; several constants of the scene besides the state) move the end by condition times that.
void explains(const Scenario& scenario, const std::vector<std::pair<Wide, const char*>>& at_end, const Truth& truth,
              double positions_scale) {
  REQUIRE(truth.outcome.status == Status::ok);
  REQUIRE(truth.condition > 0);
  double off = 0;
  for (const auto& [value, text] : at_end) off = std::max(off, static_cast<double>(fabsq(value - decimal(text))));
  const double allowed = 1e-20 * positions_scale + truth.condition * 1.1e-16 * positions_scale;
  INFO("off by " << off << ", rounding explains " << allowed << ", condition " << truth.condition);
  CHECK(off <= allowed);
  CHECK(truth.note == "");
  CHECK(truth.values.back().t_s == Wide(scenario.t_end_s));
}

Wide p(const Truth& truth, int body, int axis) { return truth.values.back().bodies[body].p_m[axis]; }

}  // namespace

TEST_CASE("truths of the rounded scenes") {
  using namespace reference_values;
  const auto planar = [](const Truth& truth, const Values& values) {
    return std::vector<std::pair<Wide, const char*>>{{p(truth, 0, 0), values.at_end[0]},
                                                     {p(truth, 0, 1), values.at_end[1]}};
  };
  SECTION("pleiades") {
    const Scenario scenario = scenes::pleiades();
    const Truth truth = extended_truth(scenario, 4);
    std::vector<std::pair<Wide, const char*>> pairs;
    double published = 0;
    for (int i = 0; i < 7; ++i)
      for (int axis = 0; axis < 2; ++axis) {
        pairs.push_back({p(truth, i, axis), pleiades.at_end[7 * axis + i]});
        published =
            std::max(published,
                     static_cast<double>(fabsq(p(truth, i, axis) - decimal(pleiades_published.at_end[7 * axis + i]))));
      }
    explains(scenario, pairs, truth, 5.3);
    CHECK(published <= pleiades_published.difference);  // this scene's decimals are doubles: nothing is rounded
    CHECK(static_cast<double>(fabsq(p(truth, 0, 0) - decimal(pleiades.at_end[0]))) < 1e-17);
  }
  SECTION("arenstorf") {
    const Scenario scenario = scenes::arenstorf(-2.00158510637908252240537862224, 17.0652165601579625588917206249);
    const Truth truth = extended_truth(scenario, 16);
    explains(scenario, planar(truth, arenstorf), truth, 1.3);
  }
  SECTION("henon-heiles") {
    const Scenario scenario = scenes::henon_heiles(100);
    const Truth truth = extended_truth(scenario, 64);
    explains(scenario, planar(truth, henon_heiles_100), truth, 0.7);
  }
  SECTION("lorenz") {
    const Scenario scenario = scenes::lorenz(10);
    const Truth truth = extended_truth(scenario, 64);
    explains(scenario, {{p(truth, 0, 0), lorenz_10.at_end[0]}, {p(truth, 0, 2), lorenz_10.at_end[2]}}, truth, 48);
    CHECK(static_cast<double>(fabsq(p(truth, 0, 0) - decimal(lorenz_10.at_end[0]))) < 1e-17);
  }
  SECTION("kepler") {
    const Scenario scenario = scenes::kepler(0.6, 10);
    const Truth truth = extended_truth(scenario, 64);
    explains(scenario, planar(truth, kepler_10), truth, 1.6);
  }
  SECTION("outer solar system") {
    const Scenario scenario = scenes::outer_solar_system();
    const Truth truth = extended_truth(scenario, 4);
    std::vector<std::pair<Wide, const char*>> pairs;
    for (int i = 0; i < 6; ++i)
      for (int axis = 0; axis < 3; ++axis)
        pairs.push_back({p(truth, i, axis), outer_solar_system.at_end[3 * i + axis]});
    explains(scenario, pairs, truth, 46);
  }
  SECTION("dzhanibekov and the asymmetric top, attitude included") {
    for (const bool flips : {false, true}) {
      const Scenario scenario =
          flips ? scenes::asymmetric_top({1e-3, 1, 1e-3}, 100) : scenes::asymmetric_top({3, 0.5, -0.9}, 10);
      const Values& values = flips ? dzhanibekov : asymmetric_top;
      const Truth truth = extended_truth(scenario, 32);
      const BodySample& end = truth.values.back().bodies[0];
      const Wide I[3] = {0.6, 0.8, 1};
      std::vector<std::pair<Wide, const char*>> pairs;
      for (int k = 0; k < 3; ++k) pairs.push_back({I[k] * end.w_rad_per_s[k], values.at_end[k]});
      for (int k = 0; k < 4; ++k) pairs.push_back({end.q_wxyz[k], values.at_end[3 + k]});
      explains(scenario, pairs, truth, flips ? 1 : 3);
    }
  }
}
