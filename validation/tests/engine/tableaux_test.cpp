// The coefficients before any physics: order conditions in quad, then polynomials through the generic stepper.
#include "integrators/tableaux.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "integrators/runge_kutta.hpp"
#include "rooted_trees.hpp"

namespace atwood::testing {
namespace {

struct Named {
  const char* name;
  const Tableau& tableau;
};
const Named all[] = {{"explicit-euler", explicit_euler_tableau},
                     {"midpoint", midpoint_tableau},
                     {"heun", heun_tableau},
                     {"ralston2", ralston2_tableau},
                     {"kutta3", kutta3_tableau},
                     {"rk4", rk4_tableau},
                     {"rk38", rk38_tableau},
                     {"bogacki-shampine3", bogacki_shampine3_tableau},
                     {"rkf45", fehlberg45_tableau},
                     {"cash-karp5", cash_karp5_tableau},
                     {"dopri5", dormand_prince5_tableau},
                     {"tsit5", tsitouras5_tableau},
                     {"verner6", verner6_tableau},
                     {"rkf78", fehlberg78_tableau},
                     {"verner8", verner8_tableau},
                     {"dop853", dormand_prince853_tableau},
                     {"verner9", verner9_tableau}};

// Residuals in units of round-off: a tree of ten nodes passes through some twenty sums and products.
constexpr double met = 20;
// Methods are designed for small errors of the next order: Verner's order-9 one misses order 10 by 1e-6.
constexpr double missed = 1e-7;

TableauRow minus(const TableauRow& x, const TableauRow& y) {
  TableauRow z;
  for (std::size_t i = 0; i < x.size(); ++i) z.push_back(x[i] - y[i]);
  return z;
}

// y' = t^degree through one step of the generic stepper, from t = 0.25 to 0.75.
struct Power {
  int degree;
};
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

// The interpolant's weights at theta, as the stepper forms them.
TableauRow dense_weights(const Tableau& tableau, const Coefficients& read, Quad theta) {
  const Quad rest = 1 - theta;
  TableauRow b;
  for (std::size_t i = 0; i < read.b.size(); ++i) {
    const Quad first = i == 0, last = static_cast<int>(i) == tableau.end_stage();
    Quad inner = 0;
    for (std::size_t n = read.dense.size(); n-- > 0;) inner = read.dense[n][i] + (n % 2 == 0 ? theta : rest) * inner;
    b.push_back(theta *
                (read.b[i] + rest * (first - read.b[i] + theta * (2 * read.b[i] - first - last + rest * inner))));
  }
  return b;
}

TEST_CASE("there are 1, 1, 2, 4, 9, 20, 48, 115, 286, 719 rooted trees") {
  const int counts[] = {1, 1, 2, 4, 9, 20, 48, 115, 286, 719};
  int found[10] = {};
  double tallest = 0;
  for (const Tree& tree : rooted_trees(10)) {
    ++found[tree.nodes - 1];
    tallest = std::fmax(tallest, tree.gamma);
  }
  for (int k = 0; k < 10; ++k) CHECK(found[k] == counts[k]);
  CHECK(tallest == 3628800);  // the tree without branchings: 10!
}

TEST_CASE("every tableau meets the order conditions of its order, and no more") {
  for (const auto& [name, tableau] : all) {
    INFO(name);
    const Coefficients read = read_coefficients(tableau);
    const OrderConditions conditions(10, read.a);
    for (int nodes = 1; nodes <= tableau.order; ++nodes) CHECK(conditions.worst(read.b, nodes).roundings < met);
    CHECK(conditions.worst(read.b, tableau.order + 1).missed > missed);
    for (std::size_t i = 0; i < read.c.size(); ++i) {
      Quad sum = -read.c[i];
      for (std::size_t j = 0; j < read.c.size(); ++j) sum += read.a[i][j];
      CHECK(std::fabs(static_cast<double>(sum)) < 1e-31);  // of entries up to 210 in size
      for (std::size_t j = i; j < read.c.size(); ++j) CHECK(read.a[i][j] == Quad(0));
    }
  }
}

TEST_CASE("the embedded weights have the order they claim, and no more") {
  int pairs = 0;
  for (const auto& [name, tableau] : all) {
    INFO(name);
    const Coefficients read = read_coefficients(tableau);
    const OrderConditions conditions(9, read.a);
    const auto check = [&](const TableauRow& error, int order) {
      const TableauRow b = minus(read.b, error);
      for (int nodes = 1; nodes <= order; ++nodes) CHECK(conditions.worst(b, nodes).roundings < met);
      CHECK(conditions.worst(b, order + 1).missed > missed);
    };
    if (tableau.embedded_order > 0) check(read.error, tableau.embedded_order);
    if (tableau.companion_order > 0) check(read.companion_error, tableau.companion_order);
    pairs += tableau.embedded_order > 0;
  }
  CHECK(pairs == 10);
}

TEST_CASE("a first-same-as-last tableau's last stage is the rate at the new state") {
  for (const auto& [name, tableau] : all) {
    if (!tableau.first_same_as_last) continue;
    INFO(name);
    const Coefficients read = read_coefficients(tableau);
    const std::size_t last = static_cast<std::size_t>(tableau.stages) - 1;
    CHECK(read.c[last] == Quad(1));
    for (std::size_t j = 0; j < read.b.size(); ++j) CHECK(read.a[last][j] == read.b[j]);
  }
}

TEST_CASE("an interpolant meets the continuous order conditions of its order, and no more") {
  int interpolants = 0;
  for (const auto& [name, tableau] : all) {
    if (tableau.dense_order == 0) continue;
    INFO(name);
    ++interpolants;
    const Coefficients read = read_coefficients(tableau);
    CHECK(read.c[static_cast<std::size_t>(tableau.end_stage())] == Quad(1));
    CHECK(read.a[static_cast<std::size_t>(tableau.end_stage())] == read.b);
    const OrderConditions conditions(tableau.dense_order + 1, read.a);
    double next = 0;
    for (const Quad theta : {Quad(1) / 8, Quad(1) / 2, Quad(3) / 4}) {
      const TableauRow b = dense_weights(tableau, read, theta);
      for (int nodes = 1; nodes <= tableau.dense_order; ++nodes)
        CHECK(conditions.worst(b, nodes, theta).roundings < met);
      next = std::fmax(next, conditions.worst(b, tableau.dense_order + 1, theta).missed);
    }
    CHECK(next > missed);
  }
  CHECK(interpolants == 7);
}

TEST_CASE("a method of order p integrates t^(p-1) to round-off") {
  for (const auto& [name, tableau] : all) {
    INFO(name);
    const long double round_off = tableau.order < 6 ? 4e-19L : 2e-18L;  // weights up to 6 in size cancel
    for (int degree = 0; degree < tableau.order; ++degree) CHECK(power_step_error(tableau, degree) < round_off);
    CHECK(power_step_error(tableau, tableau.order + 4) > 1e-12L);
  }
}

// y' = -y + t, from y = 1: the estimate is O(h^(k + 1)).
TEST_CASE("halving h divides the error estimate by 2^(k + 1), k as the step control is told") {
  for (const auto& [name, tableau] : all) {
    if (tableau.embedded_order == 0) continue;
    INFO(name);
    System<Quad> system;
    system.size = 1;
    system.rate_of = [](void*, Quad t, const Quad* y, Quad* dydt) { dydt[0] = t - y[0]; };
    ExplicitRungeKutta<Quad> stepper(system, tableau);
    const Quad y = 1;
    Quad y_new = 0, estimate[2];
    for (int k = 0; k < 2; ++k) {
      stepper.step(0, Quad(1) / Quad(64 << k), &y, &y_new);
      estimate[k] = stepper.error_norm(0, 1);
    }
    CHECK(std::log2(static_cast<double>(estimate[0] / estimate[1])) ==
          Approx(stepper.estimate_order() + 1).margin(0.1));
  }
}

// Long states are summed at the machine's own vector width, short ones are not.
template <class S> void check_same_bits() {
  const auto oscillators = [](void* size, S, const S* y, S* dydt) {
    for (int i = 0; i < *static_cast<int*>(size); i += 2) {
      dydt[i] = y[i + 1];
      dydt[i + 1] = -y[i];
    }
  };
  for (const auto& [name, tableau] : all) {
    INFO(name);
    int sizes[] = {62, 2};
    System<S> together, alone;
    together.size = sizes[0];
    together.context = &sizes[0];
    alone.size = sizes[1];
    alone.context = &sizes[1];
    together.rate_of = alone.rate_of = oscillators;
    ExplicitRungeKutta<S> wide(together, tableau), narrow(alone, tableau);
    std::vector<S> y, y_new(62), part(2);
    for (int i = 0; i < 62; ++i) y.push_back(S(1) / S(i + 3));
    wide.step(S(0), S(0.3), y.data(), y_new.data());
    for (int i = 0; i < 62; i += 2) {
      narrow.step(S(0), S(0.3), y.data() + i, part.data());
      CHECK(part[0] == y_new[i]);
      CHECK(part[1] == y_new[i + 1]);
    }
  }
}

TEST_CASE("a state's components step to the same bits together and alone") {
  check_same_bits<float>();
  check_same_bits<double>();
}

TEST_CASE("faults of a tableau are refused by name") {
  CHECK_THROWS_WITH(read_row("1/2 0.3x", 3), Catch::Contains("0.3x"));
  CHECK_THROWS_WITH(read_row("1/ 2", 3), Catch::Contains("1/"));
  CHECK_THROWS_WITH(read_row("1 2 3", 2), Catch::Contains("too long"));
  CHECK(static_cast<double>(read_row("-8/5 1e-3", 3)[0]) == -1.6);
  CHECK(read_row("1", 3)[2] == Quad(0));
}

}  // namespace
}  // namespace atwood::testing
