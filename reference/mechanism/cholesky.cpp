#include "mechanism/cholesky.hpp"

#include <algorithm>

#include "dynamics/arithmetic.hpp"

namespace atwood::mechanism {

// L_ij = (A_ij - sum_k L_ik L_jk) / L_jj
template <class S> bool factorise(Envelope<S>& A) {
  for (int i = 0; i < A.size; ++i) {
    S* row = &A(i, 0);
    for (int j = A.first[i]; j <= i; ++j) {
      const S* other = &A(j, 0);
      S sum = row[j];
      for (int k = std::max(A.first[i], A.first[j]); k < j; ++k) sum -= row[k] * other[k];
      if (j < i) {
        row[j] = sum / other[j];
        continue;
      }
      if (!(sum > 0)) return false;
      row[i] = dynamics::sqrt(sum);
    }
  }
  return true;
}

template <class S> void solve_lower(const Envelope<S>& L, S* x) {
  for (int i = 0; i < L.size; ++i) {
    S sum = x[i];
    for (int k = L.first[i]; k < i; ++k) sum -= L(i, k) * x[k];
    x[i] = sum / L(i, i);
  }
}

template <class S> void solve_upper(const Envelope<S>& L, S* x) {
  for (int i = L.size - 1; i >= 0; --i) {
    x[i] /= L(i, i);
    for (int k = L.first[i]; k < i; ++k) x[k] -= L(i, k) * x[i];
  }
}

template <class S>
Independent<S> independent_rows(std::vector<std::vector<S>> A, const std::vector<S>& diagonal, S zero) {
  const int n = static_cast<int>(A.size());
  std::vector<int> order(n);
  std::vector<S> scale(n);
  for (int i = 0; i < n; ++i) {
    order[i] = i;
    scale[i] = diagonal[i] > 0 ? 1 / dynamics::sqrt(diagonal[i]) : S(0);
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) A[i][j] *= scale[i] * scale[j];
  Independent<S> made;
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i)
      if (A[order[i]][order[i]] > A[order[best]][order[best]]) best = i;
    std::swap(order[k], order[best]);
    const int p = order[k];
    const S pivot = A[p][p];
    if (!(pivot > zero)) {
      made.largest_dropped = pivot;
      made.others.assign(order.begin() + k, order.end());
      break;
    }
    made.smallest = std::min(made.smallest, pivot);
    made.rows.push_back(p);
    for (int i = k + 1; i < n; ++i) {
      const int r = order[i];
      const S factor = A[r][p] / pivot;
      for (int j = k + 1; j < n; ++j) A[r][order[j]] -= factor * A[p][order[j]];
    }
  }
  return made;
}

#define ATWOOD_CHOLESKY(S)                           \
  template bool factorise(Envelope<S>&);             \
  template void solve_lower(const Envelope<S>&, S*); \
  template void solve_upper(const Envelope<S>&, S*); \
  template Independent<S> independent_rows(std::vector<std::vector<S>>, const std::vector<S>&, S);
ATWOOD_CHOLESKY(double)
ATWOOD_CHOLESKY(long double)
ATWOOD_CHOLESKY(__float128)
#undef ATWOOD_CHOLESKY

}  // namespace atwood::mechanism
