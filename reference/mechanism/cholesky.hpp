// Cholesky factors of symmetric positive definite matrices with an envelope, and with complete pivoting for those that
// may be singular (Golub and Van Loan, Matrix Computations, section 4.2 and 4.3), in double, long double and quad.
#pragma once

#include <vector>

namespace atwood::mechanism {

// A symmetric matrix of which the lower triangle is stored, row by row. Row i has no element other than zero before
// column first[i]; its factor has none either.
template <class S> struct Envelope {
  int size = 0;
  std::vector<int> first;
  std::vector<S> at;  // size x size

  void reset(int n) {
    size = n;
    first.resize(n);
    for (int i = 0; i < n; ++i) first[i] = i;
    at.assign(static_cast<std::size_t>(n) * n, S(0));
  }
  S& operator()(int i, int j) { return at[static_cast<std::size_t>(i) * size + j]; }
  const S& operator()(int i, int j) const { return at[static_cast<std::size_t>(i) * size + j]; }
};

// A = L L^T in place. False: a pivot is not positive.
template <class S> bool factorise(Envelope<S>& A);
// L x = b, L^T x = b, in place.
template <class S> void solve_lower(const Envelope<S>& L, S* x);
template <class S> void solve_upper(const Envelope<S>& L, S* x);

// The choice of linearly independent rows of a symmetric positive semidefinite matrix, scaled to a unit diagonal by
// `diagonal` (> 0): pivots above `zero` are taken, the largest first.
template <class S> struct Independent {
  std::vector<int> rows;             // chosen, in the order of their pivots
  std::vector<int> others;           // the rest
  S smallest{1}, largest_dropped{};  // of the scaled pivots
};
template <class S>
Independent<S> independent_rows(std::vector<std::vector<S>> A, const std::vector<S>& diagonal, S zero);

}  // namespace atwood::mechanism
