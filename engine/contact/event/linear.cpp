// The linear system of the contact rows.
#include <algorithm>

#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

// LU with row exchanges; false: a pivot is nothing.
template <class S> bool factorise(std::vector<S>& a, std::vector<int>& pivots, int n) {
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i)
      if (real::abs(a[i * n + k]) > real::abs(a[best * n + k])) best = i;
    pivots[k] = best;
    if (a[best * n + k] == S(0)) return false;
    if (best != k)
      for (int j = 0; j < n; ++j) std::swap(a[k * n + j], a[best * n + j]);
    const S inverse = S(1) / a[k * n + k];
    for (int i = k + 1; i < n; ++i) {
      const S factor = a[i * n + k] * inverse;
      a[i * n + k] = factor;
      if (factor == S(0)) continue;
      for (int j = k + 1; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
    }
  }
  return true;
}

template <class S> void substitute(const std::vector<S>& a, const std::vector<int>& pivots, int n, S* x) {
  for (int k = 0; k < n; ++k) std::swap(x[k], x[pivots[k]]);  // as the rows were exchanged while factorising
  for (int i = 1; i < n; ++i)
    for (int j = 0; j < i; ++j) x[i] -= a[i * n + j] * x[j];
  for (int i = n - 1; i >= 0; --i) {
    for (int j = i + 1; j < n; ++j) x[i] -= a[i * n + j] * x[j];
    x[i] = x[i] / a[i * n + i];
  }
}

}  // namespace

// Redundant contacts make A singular, its equations consistent. (A + e D) (x_(k+1) - x_k) = right - A x_k, D the weighted diagonal (the
// proximal point method), converges by a factor of about e a turn on what A sees, and leaves what it does not see where it started.
template <class S> void solve_rows(EventRun<S>& run, int n, bool redundant) {
  run.factors.assign(run.matrix.begin(), run.matrix.begin() + static_cast<std::ptrdiff_t>(n) * n);
  const S shift = redundant ? real::sqrt(real::epsilon<S>()) * S(16) : S(0);
  for (int i = 0; i < n; ++i) run.factors[i * n + i] += shift * run.weight[i] * real::abs(run.matrix[i * n + i]);
  if (!factorise(run.factors, run.pivots, n)) {
    run.solvable = false;
    std::fill(run.unknown.begin(), run.unknown.begin() + n, S(0));
    return;
  }
  if (!redundant) {
    std::copy(run.right.begin(), run.right.begin() + n, run.unknown.begin());
    return substitute(run.factors, run.pivots, n, run.unknown.data());
  }
  for (int turn = 0; turn < 5; ++turn) {
    for (int i = 0; i < n; ++i) {
      S left = run.right[i];
      for (int j = 0; j < n; ++j) left -= run.matrix[i * n + j] * run.unknown[j];
      run.residual[i] = left;
    }
    substitute(run.factors, run.pivots, n, run.residual.data());
    for (int i = 0; i < n; ++i) run.unknown[i] += run.residual[i];
  }
}

template void solve_rows<float>(EventRun<float>&, int, bool);
template void solve_rows<double>(EventRun<double>&, int, bool);
template void solve_rows<long double>(EventRun<long double>&, int, bool);

}  // namespace atwood::event
