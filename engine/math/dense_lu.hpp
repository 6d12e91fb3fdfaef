// Dense linear systems: Gaussian elimination with row pivots, factored once and solved often.
//
// Not taken from Eigen because states depend on it. Times of Eigen's PartialPivLU, not vectorised, relative to this
// code, for one factor() and four solve(): 1.1 to 2 times the time at 3 and 6 unknowns (a contact, a body), the same at
// 12 to 18, 0.6 to 0.9 from 26 on in float and double, 1.0 to 1.2 in long double and quad. Eigen takes sums in another
// order: its blocks from 17 unknowns on, its back substitution from 3 on.
#pragma once

#include <utility>
#include <vector>

#include "math/scalar.hpp"

namespace atwood {

template <class S> struct DenseLu {
  explicit DenseLu(int n) : size(n), entry(static_cast<std::size_t>(n) * n), pivot(n) {}

  int size;
  std::vector<S> entry;  // row-major: the matrix before factor(), L and U after it
  std::vector<int> pivot;

  S& at(int i, int j) { return entry[static_cast<std::size_t>(i) * size + j]; }

  // With a singular matrix the entries, and the results of solve(), are not finite.
  void factor() {
    for (int k = 0; k < size; ++k) {
      int p = k;
      for (int i = k + 1; i < size; ++i)
        if (real::abs(at(i, k)) > real::abs(at(p, k))) p = i;
      pivot[k] = p;
      if (p != k)
        for (int j = 0; j < size; ++j) std::swap(at(k, j), at(p, j));
      for (int i = k + 1; i < size; ++i) {
        const S multiple = at(i, k) /= at(k, k);
        if (multiple == S(0)) continue;
        for (int j = k + 1; j < size; ++j) at(i, j) -= multiple * at(k, j);
      }
    }
  }

  void solve(S* x) {
    for (int k = 0; k < size; ++k) std::swap(x[k], x[pivot[k]]);
    for (int i = 0; i < size; ++i)
      for (int j = 0; j < i; ++j) x[i] -= at(i, j) * x[j];
    for (int i = size - 1; i >= 0; --i) {
      for (int j = i + 1; j < size; ++j) x[i] -= at(i, j) * x[j];
      x[i] /= at(i, i);
    }
  }
};

}  // namespace atwood
