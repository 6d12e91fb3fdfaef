// The linear system of contact constraints: LU factors by blocks, and proximal point iteration for redundant ones.
#include "contact/event/linear_solve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace atwood::event {

namespace {

// Rows [from, to) of a matrix of n columns, which is zero outside these columns.
struct Block {
  int from, to, n;
};

// LU factors with partial pivoting, block by block of one matrix in place; states depend on the order of its sums
// (math/dense_lu.hpp compares with Eigen's). False: a pivot is zero.
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

// The factors of each block; those of a singular block give the unknowns 0.
template <class S>
void factorise_rows(const Bodies<S>& bodies, const ActiveSet<S>& active, ConstraintSystem<S>& constraints,
                    bool redundant, std::uint64_t key) {
  static const S shift = std::cbrt(real::epsilon<S>());
  assemble_delassus(bodies, active, constraints);
  const int n = constraints.row_count;
  if (redundant)
    for (int i = 0; i < n; ++i)
      constraints.matrix[i * n + i] += shift * constraints.weight[i] * constraints.diagonal[i];
  constraints.block_ends.clear();
  constraints.factors_key = key;
  for (int from = 0; from < n;) {
    const Block block{from, end_of_block(constraints.matrix.data(), from, n), n};
    constraints.block_ends.push_back(block.to);
    from = block.to;
    if (factorise(constraints.matrix.data(), constraints.pivots.data(), block)) continue;
    constraints.solvable = false;
    constraints.factors_key = 0;
    for (int i = block.from; i < block.to; ++i) {  // 1 / inf = 0
      for (int j = block.from; j < block.to; ++j) constraints.matrix[i * n + j] = S(0);
      constraints.matrix[i * n + i] = std::numeric_limits<S>::infinity();
      constraints.pivots[i] = i;
      constraints.unknown[i] = S(0);
    }
  }
}

template <class S> void substitute_rows(const ConstraintSystem<S>& constraints, S* x) {
  int from = 0;
  for (const int to : constraints.block_ends) {
    substitute(constraints.matrix.data(), constraints.pivots.data(), Block{from, to, constraints.row_count}, x);
    from = to;
  }
}

// constraints.residual = right - A unknown, from the bodies' response: A itself is not needed. Returns the square of
// its size relative to the unknowns', in the norms |r_i| / sqrt(A_ii) and |x_i| sqrt(A_ii), where forces and couples
// compare.
template <class S> S residual(const Bodies<S>& bodies, const ActiveSet<S>& active, ConstraintSystem<S>& constraints) {
  apply_unknowns(bodies, active, constraints);
  for (const Contact<S>& contact : active.contacts)
    if (contact.first_row >= 0) row_values(constraints, contact, constraints.residual.data() + contact.first_row);
  S left_square = S(0), size_square = S(0);
  for (int i = 0; i < constraints.row_count; ++i) {
    const S left = constraints.right[i] - constraints.residual[i],
            unknown = constraints.unknown[i] * constraints.diagonal[i];
    constraints.residual[i] = left;
    left_square = real::max(left_square, left * left / constraints.diagonal[i]);
    size_square = real::max(size_square, unknown * constraints.unknown[i]);
  }
  if (left_square == S(0)) return S(0);
  return size_square > S(0) ? left_square / size_square : std::numeric_limits<S>::infinity();
}

// True if the residual of each row is within the round-off of its right side.
template <class S> bool residual_is_round_off(const ConstraintSystem<S>& constraints) {
  for (int i = 0; i < constraints.row_count; ++i)
    if (!(real::abs(constraints.residual[i]) <= constraints.right_round_off[i])) return false;
  return true;
}

}  // namespace

// Redundant contacts make A singular, its equations consistent. The proximal point method
//   (A + e D) (x_(k+1) - x_k) = right - A x_k,   D the weighted diagonal
// converges by a factor of about e per iteration on the range of A and leaves the part of the start in its null space
// unchanged, up to round-off of about eps / e. With e = eps^(1/3) three iterations are enough for a well conditioned A,
// and that noise is eps^(2/3). Factors of an earlier A are reused while they are near enough; where the start is the
// solution, they are not used.
template <class S>
SolveReport solve_rows(const Bodies<S>& bodies, const ActiveSet<S>& active, ConstraintSystem<S>& constraints,
                       bool redundant, std::uint64_t key) {
  constexpr int max_iterations = 12;
  constexpr S round_off = S(4) * real::epsilon<S>(), noise = S(16) * round_off, slow = S(0x1p-6), stalled = S(0.25);
  const auto ended = [&](int iterations, S error_square, S tolerance) {
    SolveReport report{iterations, std::sqrt(static_cast<double>(error_square)), SolveEnd::capped};
    if (error_square <= tolerance * tolerance) report.ended = SolveEnd::converged;
    else if (residual_is_round_off(constraints)) report.ended = SolveEnd::stagnated;
    bodies.model.system().solvers.add(IterativeSolver::redundant_contacts, report);
    return report;
  };
  S* x = constraints.unknown.data();
  if (!redundant) {
    factorise_rows(bodies, active, constraints, false, std::uint64_t{0});
    std::fill_n(x, constraints.row_count, S(0));
    residual(bodies, active, constraints);
    std::copy_n(constraints.residual.begin(), constraints.row_count, x);
    substitute_rows(constraints, x);
    apply_unknowns(bodies, active, constraints);
    return {1, 0, constraints.solvable ? SolveEnd::converged : SolveEnd::capped};
  }
  std::copy_n(x, constraints.row_count, constraints.start.begin());
  bool fresh = key == 0 || constraints.factors_key != key;
  if (fresh) factorise_rows(bodies, active, constraints, true, key);
  S last = std::numeric_limits<S>::infinity(), error{};
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    error = residual(bodies, active, constraints);
    if (error <= round_off * round_off) return ended(iteration, error, round_off);
    const bool shrinks = error <= (fresh ? stalled * stalled : slow * slow) * last;
    if (!shrinks && (fresh || error <= noise * noise)) return ended(iteration, error, noise);
    last = error;
    if (!shrinks) {  // the earlier factors do not converge: from the start again with those of this matrix
      std::copy_n(constraints.start.begin(), constraints.row_count, x);
      factorise_rows(bodies, active, constraints, true, key);
      fresh = true;
      last = std::numeric_limits<S>::infinity();
      continue;
    }
    substitute_rows(constraints, constraints.residual.data());
    for (int i = 0; i < constraints.row_count; ++i) x[i] += constraints.residual[i];
  }
  error = residual(bodies, active, constraints);
  return ended(max_iterations, error, noise);
}

#define ATWOOD_LINEAR_SOLVE(S) \
  template SolveReport solve_rows<S>(const Bodies<S>&, const ActiveSet<S>&, ConstraintSystem<S>&, bool, std::uint64_t);
ATWOOD_LINEAR_SOLVE(float)
ATWOOD_LINEAR_SOLVE(double)
ATWOOD_LINEAR_SOLVE(long double)
#undef ATWOOD_LINEAR_SOLVE

}  // namespace atwood::event
