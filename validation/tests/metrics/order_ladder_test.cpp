// fit_ladder on real integration errors: the windows it finds by itself, the orders there, the round-off it expects.
#include <catch2/catch.hpp>
#include <cmath>

#include "reference_steppers.hpp"
#include "validation/metrics/metrics.hpp"

using namespace atwood;
using namespace atwood::test;

namespace {

constexpr int kSamples = 60;
const std::vector<int> kLadder = {60, 120, 240, 480, 960, 1920, 3840, 7680, 15360, 30720, 61440};

template <class S> using Stepper = std::function<std::vector<State<S>>(const Rate<S>&, State<S>, S, int, int)>;

// At the end of the run.
double end_error(const std::vector<State<double>>& run, const std::vector<State<long double>>& truth, std::size_t from,
                 std::size_t to) {
  long double sum = 0;
  for (std::size_t j = from; j < to; ++j) sum += (run.back()[j] - truth.back()[j]) * (run.back()[j] - truth.back()[j]);
  return static_cast<double>(std::sqrt(sum));
}

struct Problem {
  Rate<double> rate;
  Rate<long double> wide;
  State<double> start;
  double t_end = 10;
  std::size_t from = 0, to = 2;  // components of the error
  std::string quantity = "position";
  double size_position = 1, size_velocity = 1, condition = 1;
};

// Rows as a study would store them, of one method over the ladder.
std::vector<Row> ladder_rows(const Problem& p, const Stepper<double>& stepper, const std::vector<int>& ladder,
                             const std::string& method) {
  const State<long double> start(p.start.begin(), p.start.end());
  // Richardson's extrapolation of two fine runs in long double: one order better than what it judges.
  const auto coarse = rk4<long double>(p.wide, start, p.t_end, 61440, kSamples);
  auto truth = rk4<long double>(p.wide, start, p.t_end, 122880, kSamples);
  for (std::size_t k = 0; k < truth.size(); ++k)
    for (std::size_t j = 0; j < start.size(); ++j) truth[k][j] += (truth[k][j] - coarse[k][j]) / 15;
  std::vector<Row> rows;
  for (int steps : ladder) {
    const auto add = [&](const std::string& metric, double value) {
      Row r;
      r.scenario = "problem";
      r.method = method;
      r.steps = steps;
      r.h_s = p.t_end / steps;
      r.metric = metric;
      r.value = value;
      rows.push_back(r);
    };
    add("error-" + p.quantity + "-end",
        end_error(stepper(p.rate, p.start, p.t_end, steps, kSamples), truth, p.from, p.to));
    add("size-position", p.size_position);
    add("size-velocity", p.size_velocity);
    add("size-body-rate", p.size_velocity);
    add("condition", p.condition);
  }
  return rows;
}

Row order_of(const std::vector<Row>& rows) {
  const std::vector<Row> fitted = fit_ladder(rows);
  REQUIRE(fitted.size() == 1);
  INFO(fitted[0].metric << " " << fitted[0].value << " " << fitted[0].reason);
  CHECK(fitted[0].steps == 0);
  return fitted[0];
}

Problem orbit(double e) {
  const double size = 1 + e, speed = std::sqrt((1 + e) / (1 - e));
  return {.rate = kepler<double>,
          .wide = kepler<long double>,
          .start = kepler_start<double>(e),
          .size_position = size,
          .size_velocity = speed,
          .condition = 1 + 10 * speed / size};
}

}  // namespace

TEST_CASE("ladder: classical RK4 shows order 4 in the windows found by the fit") {
  const Stepper<double> stepper = rk4<double>;
  struct Case {
    std::string name;
    Problem problem;
  };
  const std::vector<Case> cases = {{"kepler e = 0", orbit(0)},
                                   {"kepler e = 0.3", orbit(0.3)},
                                   {"kepler e = 0.6", orbit(0.6)},
                                   {"kepler e = 0.8", orbit(0.8)},
                                   {"box attitude",
                                    {.rate = tumbling_box<double>,
                                     .wide = tumbling_box<long double>,
                                     .start = {0.1, 5, 0.1, 1, 0, 0, 0},
                                     .from = 3,
                                     .to = 7,
                                     .quantity = "attitude",
                                     .size_velocity = 5.1,
                                     .condition = 3000}},
                                   {"box body rate",
                                    {.rate = tumbling_box<double>,
                                     .wide = tumbling_box<long double>,
                                     .start = {0.1, 5, 0.1, 1, 0, 0, 0},
                                     .from = 0,
                                     .to = 3,
                                     .quantity = "body-rate",
                                     .size_velocity = 5.1,
                                     .condition = 3000}},
                                   {"charge in E x B",
                                    {.rate = charge<double>,
                                     .wide = charge<long double>,
                                     .start = {0, 0, 0, 1, 0, 0.1},
                                     .from = 0,
                                     .to = 3,
                                     .size_position = 2,
                                     .size_velocity = 1.2,
                                     .condition = 7}},
                                   {"quadratic drag",
                                    {.rate = thrown<double>,
                                     .wide = thrown<long double>,
                                     .start = {0, 0, 20, 20},
                                     .t_end = 2,
                                     .size_position = 40,
                                     .size_velocity = 28,
                                     .condition = 2.4}}};
  for (const Case& c : cases) {
    DYNAMIC_SECTION(c.name) {
      const Row row = order_of(ladder_rows(c.problem, stepper, kLadder, "atwood/rk4"));
      INFO(row.value << " " << row.reason);
      CHECK(row.value - row.truth_bar >= 3.9);
      CHECK(row.value + row.truth_bar <= 4.2);
      CHECK(row.reason.find("(floor)") != std::string::npos);
    }
  }
}

TEST_CASE("ladder: Verlet 2, symplectic and explicit Euler 1 on Kepler e = 0.6") {
  const std::vector<int> fine = {3840, 7680, 15360, 30720, 61440};
  const Stepper<double> verlet = [](auto& r, auto y, double t, int n, int s) {
    return kick_drift<double>(r, y, t, n, s, true);
  };
  const Stepper<double> symplectic = [](auto& r, auto y, double t, int n, int s) {
    return kick_drift<double>(r, y, t, n, s, false);
  };
  const Row two = order_of(ladder_rows(orbit(0.6), verlet, fine, "atwood/velocity-verlet"));
  CHECK(two.value == Approx(2).margin(0.05));
  const Row one = order_of(ladder_rows(orbit(0.6), symplectic, fine, "atwood/symplectic-euler"));
  CHECK(one.value == Approx(1).margin(0.1));
  // Explicit Euler on an oscillator, exact solution (cos t, -sin t).
  Problem oscillator = orbit(0);
  oscillator.rate = [](double, const State<double>& y, State<double>& d) { d = {y[1], -y[0]}; };
  oscillator.wide = [](long double, const State<long double>& y, State<long double>& d) { d = {y[1], -y[0]}; };
  oscillator.start = {1, 0};
  oscillator.to = 1;
  const Row euler = order_of(ladder_rows(oscillator, explicit_euler<double>, fine, "atwood/explicit-euler"));
  CHECK(euler.value == Approx(1).margin(0.05));
}

TEST_CASE("ladder: round-off found by experiment lies within a factor of ten of the floor expected beforehand") {
  const Problem p = orbit(0.6);
  const State<long double> start(p.start.begin(), p.start.end());
  for (int steps : {3840, 15360, 61440}) {
    const auto narrow = rk4<double>(p.rate, p.start, p.t_end, steps, kSamples);
    const auto wide = rk4<long double>(p.wide, start, p.t_end, steps, kSamples);
    const double seen = end_error(narrow, wide, 0, 2);
    const double expected = round_off_floor(unit_round_off("atwood/rk4"), steps, p.size_position, p.condition);
    CAPTURE(steps, seen, expected);
    CHECK(seen < 10 * expected);
    CHECK(seen > expected / 10);
  }
}

TEST_CASE("ladder: scalars are read from the method's id") {
  CHECK(unit_round_off("atwood/rk4") == 0x1p-53);
  CHECK(unit_round_off("atwood/rk4+event@float") == 0x1p-24);
  CHECK(unit_round_off("atwood/rk4@long-double") == 0x1p-64);
  CHECK(unit_round_off("bullet32/default") == 0x1p-24);
  CHECK(unit_round_off("bullet64/default{erp=0.1}") == 0x1p-53);
}

TEST_CASE("the floor of an error at the end is condition x unit round-off x size") {
  std::vector<Row> cell;
  const auto add = [&](const char* metric, double value) {
    Row r;
    r.method = "atwood/rk4";
    r.metric = metric;
    r.value = value;
    cell.push_back(r);
  };
  add("size-position", 3);
  CHECK(std::isnan(accuracy_floor("error-position-end", cell)));  // no condition
  add("condition", 100);
  CHECK(accuracy_floor("error-position-end", cell) == std::ldexp(300, -53));
  CHECK(accuracy_floor("error-state-end", cell) == std::ldexp(100, -53));  // relative to the state
  CHECK(std::isnan(accuracy_floor("energy-max", cell)));
  CHECK(std::isnan(accuracy_floor("error-position-max", cell)));
  for (Row& r : cell) r.method = "atwood/rk4@float";
  CHECK(accuracy_floor("error-attitude-end", cell) == std::ldexp(100, -24));
  CHECK(std::isnan(accuracy_floor("error-position-end", {})));
}

TEST_CASE("ladder: inconclusive orders are NaN with a reason; tolerances have no order; failed cells are left out") {
  std::vector<Row> rows;
  for (int steps : {64, 128, 256}) {
    Row r;
    r.method = "atwood/rk4";
    r.metric = "error-position-end";
    r.steps = steps;
    r.h_s = 1.0 / steps;
    r.value = std::pow(r.h_s, 4);
    rows.push_back(r);
  }
  const std::vector<Row> three = fit_ladder(rows);
  REQUIRE(three.size() == 1);
  CHECK(std::isnan(three[0].value));
  CHECK(three[0].reason.starts_with("inconclusive"));
  Row blown = rows[0];
  blown.metric = "status";
  blown.status = Status::diverged;
  blown.steps = 32;
  blown.h_s = 1.0 / 32;
  Row fourth = rows[0];
  fourth.steps = 512;
  fourth.h_s = 1.0 / 512;
  fourth.value = std::pow(fourth.h_s, 4);
  rows.push_back(blown);
  rows.push_back(fourth);
  const Row order = order_of(rows);
  CHECK(order.value == Approx(4));
  CHECK(order.reason.starts_with("64..512 steps, 4 rungs, +/- "));
  CHECK(order.reason.find("32 (not finite)") != std::string::npos);
  for (Row& r : rows) r.method = "cvode/adams:1e-10";
  CHECK(fit_ladder(rows).empty());
}
