#include "integrators/multistep_tables.hpp"

#include "integrators/collocation_nodes.hpp"

// clang-format off: the rows of tables stand as they are printed in their sources

namespace atwood {
namespace {

// The integral over [0, 1] of the Lagrange polynomial that is 1 at first - j and 0 at the other points first,
// first - 1, ... first - count + 1; Gauss's formula of `count` points, here on [0, 1], is exact for it.
Quad weight(const CollocationTableau& points, int first, int j) {
  const int count = points.stages;
  Quad total = Quad(0);
  for (int p = 0; p < count; ++p) {
    Quad value = points.b[p];
    for (int m = 0; m < count; ++m)
      if (m != j) value *= (points.c[p] - Quad(first - m)) / Quad(m - j);
    total += value;
  }
  return total;
}

Quad binomial(int n, int k) {
  Quad value = Quad(1);
  for (int i = 1; i <= k; ++i) value = value * Quad(n + 1 - i) / Quad(i);
  return value;
}

}  // namespace

MultistepTable adams_bashforth(int order) {
  const CollocationTableau points = gauss_collocation(order);
  MultistepTable table{order, {}, {}, Quad(0), {}, {}};
  for (int j = 0; j < order; ++j) table.rate.push_back(weight(points, 0, j));
  return table;
}

MultistepTable adams_moulton(int order) {
  const CollocationTableau points = gauss_collocation(order);
  MultistepTable table{order, {}, {}, weight(points, 1, 0), {}, {}};
  for (int j = 1; j < order; ++j) table.rate.push_back(weight(points, 1, j));
  table.guess_rate = adams_bashforth(order - 1).rate;
  return table;
}

// nabla^m y_(n+1) = nabla^(m-1) d_0 = sum_i (-1)^i C(m-1, i) d_i, solved for d_0 = y_(n+1) - y_n:
//   (sum_m 1/m) d_0 = h f_(n+1) - sum_(i>=1) d_i sum_(m>i) (-1)^i C(m-1, i) / m
// The guess continues the differences: nabla^(order-1) d_0 = 0.
MultistepTable bdf(int order) {
  Quad lead = Quad(0);
  for (int m = 1; m <= order; ++m) lead += Quad(1) / Quad(m);
  MultistepTable table{order, {}, {}, Quad(1) / lead, {}, {}};
  for (int i = 1; i < order; ++i) {
    Quad sum = Quad(0);
    for (int m = i + 1; m <= order; ++m) sum += binomial(m - 1, i) / Quad(m);
    const Quad sign = i % 2 == 0 ? Quad(1) : Quad(-1);
    table.increment.push_back(-sign * sum / lead);
    table.guess_increment.push_back(-sign * binomial(order - 1, i));
  }
  return table;
}

}  // namespace atwood
