// Monomials z_1^a z_2^b z_3^e of up to a degree, and their weighted sums over a neighbourhood.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "math/lanes.hpp"
#include "math/vector_width.hpp"

namespace atwood::fluid {

using Exponents = std::array<int, 3>;

// Number of monomials of degree 0 .. q in d variables: (q + d)! / (q! d!).
constexpr int monomial_count(int d, int q) { return d == 2 ? (q + 1) * (q + 2) / 2 : (q + 1) * (q + 2) * (q + 3) / 6; }

// The basis of a fit: monomials of degree 1 .. p, by descending degree, so that a factorisation in this order ends with
// the linear and the quadratic ones, whose coefficients alone are wanted. In 2-D: ... x^2, xy, y^2, x, y.
template <int d, int p> struct Basis {
  static constexpr int count = monomial_count(d, p) - 1;
  static constexpr int wanted = monomial_count(d, 2) - 1;  // the last ones: degrees 2 and 1
  static constexpr std::array<Exponents, count> exponents = [] {
    std::array<Exponents, count> all{};
    int k = 0;
    for (int degree = p; degree >= 1; --degree)
      for (int a = degree; a >= 0; --a)
        for (int b = degree - a; b >= (d == 2 ? degree - a : 0); --b) all[k++] = {a, b, degree - a - b};
    return all;
  }();
  static constexpr int index_of(const Exponents& e) {
    for (int k = 0; k < count; ++k)
      if (exponents[k] == e) return k;
    return -1;
  }
};

// All monomials of degree 0 .. q, in rows of constant (b, e) along which a grows: the order in which sums are made, as
// each monomial of a row is the one before it times z_1.
template <int d, int q> struct MonomialRows {
  struct Row {
    int b, e, first, length;
  };
  static constexpr int rows = d == 2 ? q + 1 : (q + 1) * (q + 2) / 2;
  static constexpr int count = monomial_count(d, q);
  static constexpr std::array<Row, rows> row = [] {
    std::array<Row, rows> all{};
    int r = 0, first = 0;
    for (int e = 0; e <= (d == 2 ? 0 : q); ++e) {
      for (int b = 0; b + e <= q; ++b) {
        all[r++] = {b, e, first, q - b - e + 1};
        first += q - b - e + 1;
      }
    }
    return all;
  }();
  static constexpr int index_of(const Exponents& e) {
    for (const Row& r : row)
      if (r.b == e[1] && r.e == e[2]) return r.first + e[0];
    return -1;
  }
};

// The rows [first, last) of MonomialRows<d, q> whose sums are made in one pass over the neighbours: as many as leave
// the sums in vector registers.
inline constexpr int kSumsInRegisters = 18;
template <int d, int q> constexpr int pass_end(int first) {
  using Rows = MonomialRows<d, q>;
  int last = first + 1, sums = Rows::row[first].length;
  while (last < Rows::rows && sums + Rows::row[last].length <= kSumsInRegisters) sums += Rows::row[last++].length;
  return last;
}

template <int n, class V> ATWOOD_INLINE V times_power(V value, const V& z) {
  if constexpr (n == 0) return value;
  else return times_power<n - 1>(V(value * z), z);
}

// One row for one neighbour: sums[a] += start z_1^a.
template <class V, std::size_t... a>
ATWOOD_INLINE void add_row(V start, const V& z, V* sums, std::index_sequence<a...>) {
  ((sums[a] = sums[a] + start, start = start * z), ...);
}

template <int d, int q, int first, int last, class V, class WeightOf, std::size_t... r>
ATWOOD_INLINE void sum_pass(int neighbours, const V* z, const WeightOf& weight_of, V* out, std::index_sequence<r...>) {
  using Rows = MonomialRows<d, q>;
  constexpr int begin = Rows::row[first].first, size = Rows::row[last - 1].first + Rows::row[last - 1].length - begin;
  V sums[size]{};
  for (int n = 0; n < neighbours; ++n) {
    const V weight = weight_of(n);
    const V* const at = z + n * d;
    const V x = at[0], y = at[1], up = at[d - 1];
    ((add_row(times_power<Rows::row[first + r].e>(times_power<Rows::row[first + r].b>(weight, y), up), x,
              sums + (Rows::row[first + r].first - begin), std::make_index_sequence<Rows::row[first + r].length>{})),
     ...);
  }
  for (int k = 0; k < size; ++k) out[begin + k] = sums[k];
}

// out[index_of(e)] = sum over n of weight_of(n) z_n^e, all e of degree 0 .. q. `z` holds d values a neighbour.
template <int d, int q, int first = 0, class V, class WeightOf>
ATWOOD_INLINE void monomial_sums(int neighbours, const V* z, const WeightOf& weight_of, V* out) {
  if constexpr (first < MonomialRows<d, q>::rows) {
    constexpr int last = pass_end<d, q>(first);
    sum_pass<d, q, first, last>(neighbours, z, weight_of, out, std::make_index_sequence<last - first>{});
    monomial_sums<d, q, last>(neighbours, z, weight_of, out);
  }
}

}  // namespace atwood::fluid
