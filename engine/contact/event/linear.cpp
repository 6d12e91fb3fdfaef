// The linear system of the contact rows.
#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

// Rows [from, to) of a matrix of `n` columns, which has nothing outside these columns.
struct Block {
  int from, to, n;
};

// LU with row exchanges; false: a pivot is nothing.
template <class S> bool factorise(S* a, int* pivots, const Block& block) {
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

template <class S> void substitute(const S* a, const int* pivots, const Block& block, S* x) {
  const int n = block.n, from = block.from, to = block.to;
  for (int k = from; k < to; ++k)
    if (pivots[k] != k) std::swap(x[k], x[pivots[k]]);  // as the rows were exchanged while factorising
  for (int i = from + 1; i < to; ++i) {
    S left = x[i];
    for (int j = from; j < i; ++j) left -= a[i * n + j] * x[j];
    x[i] = left;
  }
  for (int i = to - 1; i >= from; --i) {
    S left = x[i];
    for (int j = i + 1; j < to; ++j) left -= a[i * n + j] * x[j];
    x[i] = left / a[i * n + i];
  }
}

template <class S> int end_of_block(const S* a, int from, int n) {
  int end = from + 1;
  for (int i = from; i < end; ++i)
    for (int j = n - 1; j >= end; --j)
      if (a[i * n + j] != S(0) || a[j * n + i] != S(0)) end = j + 1;
  return end;
}

// Blocks one after another; where one has no factors, its unknowns are 0.
template <class S> void factorise_rows(EventRun<S>& run, bool redundant) {
  static const S shift = std::cbrt(real::epsilon<S>());
  fill_matrix(run);
  const int n = run.row_count;
  if (redundant)
    for (int i = 0; i < n; ++i) run.matrix[i * n + i] += shift * run.weight[i] * run.diagonal[i];
  run.block_ends.clear();
  run.has_factors = true;
  for (int from = 0; from < n;) {
    const Block block{from, end_of_block(run.matrix.data(), from, n), n};
    run.block_ends.push_back(block.to);
    from = block.to;
    if (factorise(run.matrix.data(), run.pivots.data(), block)) continue;
    run.solvable = run.has_factors = false;
    for (int i = block.from; i < block.to; ++i) {  // nothing from nothing
      for (int j = block.from; j < block.to; ++j) run.matrix[i * n + j] = S(0);
      run.matrix[i * n + i] = std::numeric_limits<S>::infinity();
      run.pivots[i] = i;
      run.unknown[i] = S(0);
    }
  }
}

template <class S> void substitute_rows(const EventRun<S>& run, S* x) {
  int from = 0;
  for (const int to : run.block_ends) {
    substitute(run.matrix.data(), run.pivots.data(), Block{from, to, run.row_count}, x);
    from = to;
  }
}

// What the unknowns leave of the right side, into run.residual, by way of what they do to the bodies: A is not needed.
// Returns the square of its size relative to the unknowns' in the norm |r_i| / sqrt(A_ii), |x_i| sqrt(A_ii), where
// forces and couples compare.
template <class S> S residual(EventRun<S>& run) {
  answer_unknowns(run);
  for (const Contact<S>& contact : run.contacts)
    if (contact.first_row >= 0) read_rows(run, contact, run.residual.data() + contact.first_row);
  S left_square = S(0), size_square = S(0);
  for (int i = 0; i < run.row_count; ++i) {
    const S left = run.right[i] - run.residual[i], unknown = run.unknown[i] * run.diagonal[i];
    run.residual[i] = left;
    left_square = real::max(left_square, left * left / run.diagonal[i]);
    size_square = real::max(size_square, unknown * run.unknown[i]);
  }
  if (left_square == S(0)) return S(0);
  return size_square > S(0) ? left_square / size_square : std::numeric_limits<S>::infinity();
}

}  // namespace

// Redundant contacts make A singular, its equations consistent. (A + e D) (x_(k+1) - x_k) = right - A x_k, D the
// weighted diagonal (the proximal point method), converges by a factor of about e a turn on what A sees, and leaves
// what it does not see where it started, but for round-off of about eps / e: with e = eps^(1/3) three turns are enough
// of a well conditioned A, and that noise is eps^(2/3). Factors of an earlier A do as well as long as they are near
// enough; where the unknowns start as the solution, they are not used.
template <class S> void solve_rows(EventRun<S>& run, bool redundant, bool keep_factors) {
  constexpr int most_turns = 12;
  constexpr S round_off = S(4) * real::epsilon<S>(), noise = S(16) * round_off, slow = S(0x1p-6), stalled = S(0.25);
  S* x = run.unknown.data();
  if (!redundant) {
    factorise_rows(run, false);
    std::fill_n(x, run.row_count, S(0));
    residual(run);
    std::copy_n(run.residual.begin(), run.row_count, x);
    substitute_rows(run, x);
    run.has_factors = run.answered = false;
    return;
  }
  std::copy_n(x, run.row_count, run.start.begin());
  bool fresh = !run.has_factors || !keep_factors;
  if (fresh) factorise_rows(run, true);
  S last = std::numeric_limits<S>::infinity();
  for (int turn = 0; turn < most_turns; ++turn) {
    const S error = residual(run);
    if (error <= round_off * round_off) return;
    const bool shrinks = error <= (fresh ? stalled * stalled : slow * slow) * last;
    if (!shrinks && (fresh || error <= noise * noise)) return;
    last = error;
    if (!shrinks) {  // the earlier factors led nowhere: from the start again
      std::copy_n(run.start.begin(), run.row_count, x);
      factorise_rows(run, true);
      fresh = true;
      last = std::numeric_limits<S>::infinity();
      continue;
    }
    substitute_rows(run, run.residual.data());
    for (int i = 0; i < run.row_count; ++i) x[i] += run.residual[i];
    run.answered = false;
  }
}

template void solve_rows<float>(EventRun<float>&, bool, bool);
template void solve_rows<double>(EventRun<double>&, bool, bool);
template void solve_rows<long double>(EventRun<long double>&, bool, bool);

}  // namespace atwood::event
