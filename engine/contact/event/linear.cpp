// The linear system of the contact rows.
#include <algorithm>

#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

// Rows [from, to) of a matrix of `n` columns, which has nothing outside these columns.
struct Block { int from, to, n; };

// LU with row exchanges; false: a pivot is nothing.
template <class S> bool factorise(std::vector<S>& a, std::vector<int>& pivots, const Block& block) {
  const int n = block.n, to = block.to;
  for (int k = block.from; k < to; ++k) {
    int best = k;
    for (int i = k + 1; i < to; ++i)
      if (real::abs(a[i * n + k]) > real::abs(a[best * n + k])) best = i;
    pivots[k] = best;
    if (a[best * n + k] == S(0)) return false;
    if (best != k)
      for (int j = block.from; j < to; ++j) std::swap(a[k * n + j], a[best * n + j]);
    const S inverse = S(1) / a[k * n + k];
    for (int i = k + 1; i < to; ++i) {
      const S factor = a[i * n + k] * inverse;
      a[i * n + k] = factor;
      if (factor == S(0)) continue;
      for (int j = k + 1; j < to; ++j) a[i * n + j] -= factor * a[k * n + j];
    }
  }
  return true;
}

template <class S> void substitute(const std::vector<S>& a, const std::vector<int>& pivots, const Block& block, S* x) {
  const int n = block.n, from = block.from, to = block.to;
  for (int k = from; k < to; ++k) std::swap(x[k], x[pivots[k]]);  // as the rows were exchanged while factorising
  for (int i = from + 1; i < to; ++i)
    for (int j = from; j < i; ++j) x[i] -= a[i * n + j] * x[j];
  for (int i = to - 1; i >= from; --i) {
    for (int j = i + 1; j < to; ++j) x[i] -= a[i * n + j] * x[j];
    x[i] = x[i] / a[i * n + i];
  }
}

template <class S> int end_of_block(const std::vector<S>& a, int from, int n) {
  int end = from + 1;
  for (int i = from; i < end; ++i)
    for (int j = n - 1; j >= end; --j)
      if (a[i * n + j] != S(0) || a[j * n + i] != S(0)) end = j + 1;
  return end;
}

}  // namespace

// Redundant contacts make A singular, its equations consistent. (A + e D) (x_(k+1) - x_k) = right - A x_k, D the weighted diagonal (the
// proximal point method), converges by a factor of about e a turn on what A sees, and leaves what it does not see where it started.
template <class S> void solve_rows(EventRun<S>& run, int n, bool redundant) {
  run.factors.assign(run.matrix.begin(), run.matrix.begin() + static_cast<std::ptrdiff_t>(n) * n);
  const S shift = redundant ? real::sqrt(real::epsilon<S>()) * S(16) : S(0);
  for (int i = 0; i < n; ++i) run.factors[i * n + i] += shift * run.weight[i] * real::abs(run.matrix[i * n + i]);
  for (int from = 0; from < n;) {  // contacts of bodies that do not touch each other stand apart
    const Block block{from, end_of_block(run.matrix, from, n), n};
    from = block.to;
    if (!factorise(run.factors, run.pivots, block)) {
      run.solvable = false;
      std::fill(run.unknown.begin() + block.from, run.unknown.begin() + block.to, S(0));
      continue;
    }
    if (!redundant) {
      std::copy(run.right.begin() + block.from, run.right.begin() + block.to, run.unknown.begin() + block.from);
      substitute(run.factors, run.pivots, block, run.unknown.data());
      continue;
    }
    for (int turn = 0; turn < 5; ++turn) {
      for (int i = block.from; i < block.to; ++i) {
        S left = run.right[i];
        for (int j = block.from; j < block.to; ++j) left -= run.matrix[i * n + j] * run.unknown[j];
        run.residual[i] = left;
      }
      substitute(run.factors, run.pivots, block, run.residual.data());
      for (int i = block.from; i < block.to; ++i) run.unknown[i] += run.residual[i];
    }
  }
}

template void solve_rows<float>(EventRun<float>&, int, bool);
template void solve_rows<double>(EventRun<double>&, int, bool);
template void solve_rows<long double>(EventRun<long double>&, int, bool);

}  // namespace atwood::event
