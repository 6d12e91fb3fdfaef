// The collocation tables: simplifying conditions in quad, and the small ones against their closed forms.
#include <catch2/catch.hpp>

#include "integrators/collocation_nodes.hpp"

using namespace atwood;

namespace {

Quad power(Quad x, int n) {
  Quad product = Quad(1);
  for (int k = 0; k < n; ++k) product *= x;
  return product;
}

// Hairer, Wanner, Solving ODEs II, section IV.5:
//   B(p): sum_i b_i c_i^(k-1) = 1/k for k <= p      C(s): sum_j a_ij c_j^(k-1) = c_i^k / k for k <= s
//   D(z): sum_i b_i c_i^(k-1) a_ij = b_j (1 - c_j^k) / k for k <= z
double largest_misfit(const CollocationTableau& t, int quadrature, int transposed) {
  const int s = t.stages;
  Quad worst = Quad(0);
  for (int k = 1; k <= quadrature; ++k) {
    Quad sum = Quad(-1) / Quad(k);
    for (int i = 0; i < s; ++i) sum += t.b[i] * power(t.c[i], k - 1);
    worst = real::max(worst, real::abs(sum));
  }
  for (int i = 0; i < s; ++i)
    for (int k = 1; k <= s; ++k) {
      Quad sum = -power(t.c[i], k) / Quad(k);
      for (int j = 0; j < s; ++j) sum += t.a[i * s + j] * power(t.c[j], k - 1);
      worst = real::max(worst, real::abs(sum));
    }
  for (int j = 0; j < s; ++j)
    for (int k = 1; k <= transposed; ++k) {
      Quad sum = -t.b[j] * (Quad(1) - power(t.c[j], k)) / Quad(k);
      for (int i = 0; i < s; ++i) sum += t.b[i] * power(t.c[i], k - 1) * t.a[i * s + j];
      worst = real::max(worst, real::abs(sum));
    }
  return static_cast<double>(worst / real::epsilon<Quad>());
}

double apart(Quad a, Quad b) { return static_cast<double>(real::abs(a - b) / real::epsilon<Quad>()); }

}  // namespace

TEST_CASE("collocation tables hold their simplifying conditions to quad's round-off") {
  for (int s = 1; s <= 12; ++s) {
    CAPTURE(s);
    CHECK(largest_misfit(gauss_collocation(s), 2 * s, s) < 8);
    CHECK(largest_misfit(radau_right_collocation(s), 2 * s - 1, s - 1) < 8);
    CHECK(largest_misfit(radau_left_collocation(s), 2 * s - 1, s - 1) < 8);
    CHECK(radau_right_collocation(s).c.back() == Quad(1));
    CHECK(radau_left_collocation(s).c.front() == Quad(0));
  }
}

TEST_CASE("a misprinted digit of a collocation table is seen") {
  CollocationTableau t = gauss_collocation(4);
  t.a[5] += Quad(1e-30);
  CHECK(largest_misfit(t, 8, 4) > 1e3);
}

TEST_CASE("small collocation tables are the published ones") {
  const Quad root3 = real::sqrt(Quad(3)), root15 = real::sqrt(Quad(15)), root6 = real::sqrt(Quad(6));
  const CollocationTableau g2 = gauss_collocation(2);  // Solving ODEs II, table IV.5.1
  CHECK(apart(g2.c[0], Quad(1) / 2 - root3 / 6) < 2);
  CHECK(apart(g2.a[1], Quad(1) / 4 - root3 / 6) < 2);
  CHECK(apart(g2.a[2], Quad(1) / 4 + root3 / 6) < 2);
  CHECK(apart(g2.b[0], Quad(1) / 2) < 2);
  const CollocationTableau g3 = gauss_collocation(3);  // table IV.5.2
  CHECK(apart(g3.c[2], Quad(1) / 2 + root15 / 10) < 2);
  CHECK(apart(g3.a[2], Quad(5) / 36 - root15 / 30) < 2);
  CHECK(apart(g3.a[4], Quad(2) / 9) < 2);
  const CollocationTableau r3 = radau_right_collocation(3);  // table IV.5.6
  CHECK(apart(r3.c[0], (Quad(4) - root6) / 10) < 2);
  CHECK(apart(r3.a[0], (Quad(88) - 7 * root6) / 360) < 2);
  CHECK(apart(r3.a[5], (Quad(-2) - 3 * root6) / 225) < 2);
  CHECK(apart(r3.b[2], Quad(1) / 9) < 2);
  const CollocationTableau l2 = radau_left_collocation(2);
  CHECK(apart(l2.c[1], Quad(2) / 3) < 2);
  CHECK(apart(l2.b[0], Quad(1) / 4) < 2);
  // Everhart, in Dynamics of Comets (1985) 185: the spacings of the 15th order integrator
  const CollocationTableau l8 = radau_left_collocation(8);
  CHECK(static_cast<double>(l8.c[1]) == Approx(0.05626256053692215).epsilon(1e-14));
  CHECK(static_cast<double>(l8.c[7]) == Approx(0.97752061356128750).epsilon(1e-14));
}
