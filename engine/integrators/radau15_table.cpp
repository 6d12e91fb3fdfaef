// The coefficients of Radau 15, computed in quad.
#include "integrators/collocation_nodes.hpp"
#include "integrators/radau15.hpp"

namespace atwood {
namespace {

struct WideTable {
  std::vector<Quad> c, b, a;
  Quad power[kRadauNodes][kRadauNodes];  // of the Lagrange polynomial of node j

  WideTable() {
    const CollocationTableau tableau = radau_left_collocation(kRadauNodes);
    c = tableau.c;
    b = tableau.b;
    a = tableau.a;
    for (int j = 0; j < kRadauNodes; ++j) {  // prod over m != j of (tau - c_m) / (c_j - c_m)
      std::vector<Quad> product{Quad(1)};
      for (int m = 0; m < kRadauNodes; ++m) {
        if (m == j) continue;
        product.push_back(Quad(0));
        for (int k = static_cast<int>(product.size()) - 1; k >= 0; --k)
          product[k] = ((k > 0 ? product[k - 1] : Quad(0)) - c[m] * product[k]) / (c[j] - c[m]);
      }
      for (int k = 0; k < kRadauNodes; ++k) power[j][k] = product[k];
    }
  }
};

template <class S> RadauTable<S> narrow_table() {
  static const WideTable wide;
  RadauTable<S> table{};
  for (int i = 0; i < kRadauNodes; ++i) {
    table.c[i] = S(wide.c[i]);
    Quad b2 = Quad(0);
    for (int j = 0; j < kRadauNodes; ++j) {
      Quad a2 = Quad(0), newton = j < i ? Quad(0) : Quad(1);
      for (int m = 0; m < kRadauNodes; ++m) a2 += wide.a[i * kRadauNodes + m] * wide.a[m * kRadauNodes + j];
      for (int m = 0; m < i; ++m) newton *= (wide.c[j] - wide.c[m]) / (wide.c[i] - wide.c[m]);
      table.a[j][i] = table.row[i][j] = S(wide.a[i * kRadauNodes + j]);
      table.a2[j][i] = table.row2[i][j] = S(a2);
      table.power[j][i] = S(wide.power[j][i]);
      table.newton[i][j] = S(newton);
      b2 += wide.b[j] * wide.a[j * kRadauNodes + i];
    }
    table.ends[i][0] = S(wide.b[i]);
    table.ends[i][1] = S(b2);
    table.ends[i][2] = S(wide.power[i][kRadauNodes - 1]);
  }
  return table;
}

}  // namespace

template <class S> const RadauTable<S>& radau_table() {
  static const RadauTable<S> table = narrow_table<S>();
  return table;
}

template const RadauTable<float>& radau_table();
template const RadauTable<double>& radau_table();
template const RadauTable<long double>& radau_table();
template const RadauTable<Quad>& radau_table();

}  // namespace atwood
