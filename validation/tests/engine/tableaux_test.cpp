// The coefficients before any physics: order conditions in quad, then polynomials through the generic stepper.
#include "integrators/tableaux.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "integrators/runge_kutta.hpp"
#include "math/scalar.hpp"

namespace atwood {
namespace {

using Row = std::vector<Quad>;
struct Coefficients { std::vector<Row> a; Row b, c; };

Coefficients widened(const Tableau& tableau) {
  Coefficients t;
  for (int i = 0; i < tableau.stages; ++i) {
    t.a.emplace_back();
    for (int j = 0; j < tableau.stages; ++j) t.a.back().push_back(tableau.a[i][j].as<Quad>());
    t.b.push_back(tableau.b[i].as<Quad>());
    t.c.push_back(tableau.c[i].as<Quad>());
  }
  return t;
}

Row times(const Row& x, const Row& y) {
  Row z;
  for (std::size_t i = 0; i < x.size(); ++i) z.push_back(x[i] * y[i]);
  return z;
}
Row stage_sums(const std::vector<Row>& a, const Row& x) {
  Row z;
  for (const Row& row : a) {
    Quad sum = 0;
    for (std::size_t j = 0; j < x.size(); ++j) sum += row[j] * x[j];
    z.push_back(sum);
  }
  return z;
}

// A rooted tree: its elementary weight at every stage, its order, its density (HNW I, theorem II.2.13: sum b phi =
// 1/gamma).
struct Tree { Row phi; int order, gamma; };

std::vector<Tree> trees_up_to_5(const Coefficients& t) {
  const Row one(t.c.size(), 1), &c = t.c;
  const Row c2 = times(c, c), c3 = times(c2, c), c4 = times(c3, c);
  const auto A = [&](const Row& x) { return stage_sums(t.a, x); };
  const Row ac = A(c), ac2 = A(c2), aac = A(ac);
  return {{one, 1, 1},
          {c, 2, 2},
          {c2, 3, 3}, {ac, 3, 6},
          {c3, 4, 4}, {times(c, ac), 4, 8}, {ac2, 4, 12}, {aac, 4, 24},
          {c4, 5, 5}, {times(c2, ac), 5, 10}, {times(ac, ac), 5, 20}, {times(c, ac2), 5, 15}, {A(c3), 5, 20},
          {times(c, aac), 5, 30}, {A(times(c, ac)), 5, 40}, {A(ac2), 5, 60}, {A(aac), 5, 120}};
}

double residual(const Row& b, const Tree& tree, Quad power = 1) {
  Quad sum = -power / tree.gamma;
  for (std::size_t i = 0; i < b.size(); ++i) sum += b[i] * tree.phi[i];
  return std::fabs(static_cast<double>(sum));
}

int order_of(const Row& b, const std::vector<Tree>& trees) {
  int order = 5;
  for (const Tree& tree : trees)
    if (residual(b, tree) > 1e-30) order = std::min(order, tree.order - 1);
  return order;
}

struct Named { const char* name; const Tableau& tableau; };
const Named all[] = {{"explicit-euler", explicit_euler_tableau}, {"midpoint", midpoint_tableau}, {"heun", heun_tableau},
                     {"rk4", rk4_tableau}, {"rkf45", fehlberg45_tableau}, {"dopri5", dormand_prince5_tableau}};

// y' = t^degree through one step of the generic stepper, from t = 0.25 to 0.75.
struct Power { int degree; };
long double power_step_error(const Tableau& tableau, int degree) {
  Power power{degree};
  System<long double> system;
  system.size = 1;
  system.context = &power;
  system.rate_of = [](void* p, long double t, const long double*, long double* dydt) {
    dydt[0] = std::pow(t, static_cast<long double>(static_cast<Power*>(p)->degree));
  };
  ExplicitRungeKutta<long double> stepper(system, tableau);
  const long double y = 1;
  long double y_new = 0;
  stepper.step(0.25L, 0.5L, &y, &y_new);
  const long double n = degree + 1;
  return std::fabs(y_new - (1 + (std::pow(0.75L, n) - std::pow(0.25L, n)) / n));
}

TEST_CASE("every tableau meets the order conditions of its order, and no more") {
  for (const auto& [name, tableau] : all) {
    INFO(name);
    const Coefficients t = widened(tableau);
    CHECK(order_of(t.b, trees_up_to_5(t)) == tableau.order);
    for (std::size_t i = 0; i < t.c.size(); ++i) {
      Quad sum = -t.c[i];
      for (std::size_t j = 0; j < t.c.size(); ++j) sum += t.a[i][j];
      CHECK(std::fabs(static_cast<double>(sum)) < 1e-32);
      for (std::size_t j = i; j < t.c.size(); ++j) CHECK(tableau.a[i][j].over == 0);
    }
  }
}

TEST_CASE("embedded weights have the order they claim") {
  for (const Tableau* tableau : {&fehlberg45_tableau, &dormand_prince5_tableau}) {
    const Coefficients t = widened(*tableau);
    Row embedded = t.b;
    for (std::size_t i = 0; i < embedded.size(); ++i) embedded[i] -= tableau->error_weight[i].as<Quad>();
    CHECK(order_of(embedded, trees_up_to_5(t)) == tableau->embedded_order);
  }
}

TEST_CASE("dopri5: order 6 is not met, the last stage is the rate at the new state") {
  const Coefficients t = widened(dormand_prince5_tableau);
  Tree sixth{times(times(t.c, t.c), times(t.c, times(t.c, t.c))), 6, 6};
  Tree chain{stage_sums(t.a, times(times(t.c, t.c), times(t.c, t.c))), 6, 30};
  CHECK(std::max(residual(t.b, sixth), residual(t.b, chain)) > 1e-5);
  CHECK(dormand_prince5_tableau.first_same_as_last);
  for (std::size_t j = 0; j < t.b.size(); ++j) CHECK(static_cast<double>(t.a.back()[j] - t.b[j]) == 0);
}

// b_i(theta) as the stepper forms them; order 4: sum b_i(theta) phi_i = theta^order / gamma.
TEST_CASE("dopri5's interpolant meets the continuous order conditions to order 4") {
  const Tableau& tableau = dormand_prince5_tableau;
  const Coefficients t = widened(tableau);
  bool fifth_fails = false;
  for (const Quad theta : {Quad(0.1), Quad(0.5), Quad(0.75)}) {
    const Quad rest = 1 - theta;
    Row b;
    for (int i = 0; i < tableau.stages; ++i) {
      const Quad first = i == 0, last = i == tableau.stages - 1, d = tableau.dense_weight[i].as<Quad>();
      b.push_back(theta * (t.b[i] + rest * (first - t.b[i] + theta * (2 * t.b[i] - first - last + rest * d))));
    }
    for (const Tree& tree : trees_up_to_5(t)) {
      Quad power = 1;
      for (int k = 0; k < tree.order; ++k) power *= theta;
      if (tree.order <= 4) CHECK(residual(b, tree, power) < 1e-30);
      else fifth_fails = fifth_fails || residual(b, tree, power) > 1e-6;
    }
  }
  CHECK(fifth_fails);
}

TEST_CASE("a method of order p integrates t^(p-1) to round-off, and t^(p+1) not") {
  for (const auto& [name, tableau] : all) {
    INFO(name);
    for (int degree = 0; degree < tableau.order; ++degree) CHECK(power_step_error(tableau, degree) < 4e-19L);
    CHECK(power_step_error(tableau, tableau.order + 1) > 1e-8L);
  }
}

// Local error of the order-4 results: h^5. y' = -y + t, from y = 1.
TEST_CASE("halving h divides the error estimate by 2^5") {
  for (const Tableau* tableau : {&fehlberg45_tableau, &dormand_prince5_tableau}) {
    System<long double> system;
    system.size = 1;
    system.rate_of = [](void*, long double t, const long double* y, long double* dydt) { dydt[0] = t - y[0]; };
    ExplicitRungeKutta<long double> stepper(system, *tableau);
    const long double y = 1;
    long double y_new = 0, estimate[2];
    for (int k = 0; k < 2; ++k) {
      stepper.step(0, 0.01L / (1 << k), &y, &y_new);
      estimate[k] = stepper.error_norm(0, 1);
    }
    CHECK(static_cast<double>(estimate[0] / estimate[1]) == Approx(32).epsilon(0.05));
  }
}

}  // namespace
}  // namespace atwood
