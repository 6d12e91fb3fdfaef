// A small linear complementarity problem, solved by enumeration of the sets of active contacts (R. W. Cottle, J.-S.
// Pang and R. E. Stone, The Linear Complementarity Problem, 1992, section 1.1).
#pragma once

#include <cstddef>
#include <vector>

namespace atwood::dynamics {

// With more contacts there are too many sets to enumerate (2^n).
inline constexpr std::size_t kMaxSimultaneous = 12;

// Solves A x = b by LU with complete pivoting (Eigen), at most kMaxSimultaneous unknowns. False: a pivot is
// not above `least` times the largest diagonal element; x is then undefined. S: double, long double or Wide.
template <class S>
bool eliminate(const std::vector<std::vector<S>>& A, const std::vector<S>& b, S least, std::vector<S>& x);

// Solves the LCP w = A x + q, x >= 0, w >= 0, x_i w_i = 0, with a tolerance of `slack` in w. A is symmetric and
// positive semidefinite, so that w is the same for each set of active contacts that is a solution. A pivot below
// `least`, relative to the largest diagonal element, means linearly dependent contacts. False: no set is a solution, or
// n is more than kMaxSimultaneous.
template <class S>
bool solve_lcp(const std::vector<std::vector<S>>& A, const std::vector<S>& q, S slack, S least, std::vector<S>& x) {
  const std::size_t n = q.size();
  if (n > kMaxSimultaneous) return false;
  for (std::size_t set = 0; set < (std::size_t(1) << n); ++set) {
    std::vector<std::size_t> active;
    for (std::size_t i = 0; i < n; ++i)
      if ((set >> i) & 1) active.push_back(i);
    std::vector<std::vector<S>> part(active.size(), std::vector<S>(active.size()));
    std::vector<S> right, found;
    for (std::size_t i = 0; i < active.size(); ++i) {
      right.push_back(-q[active[i]]);
      for (std::size_t j = 0; j < active.size(); ++j) part[i][j] = A[active[i]][active[j]];
    }
    if (!eliminate(part, right, least, found)) continue;
    x.assign(n, S(0));
    bool feasible = true;
    for (std::size_t i = 0; i < active.size(); ++i) {
      feasible = feasible && found[i] * A[active[i]][active[i]] >= -slack;
      x[active[i]] = found[i] > 0 ? found[i] : S(0);
    }
    for (std::size_t i = 0; i < n && feasible; ++i) {
      S w = q[i];
      for (std::size_t j = 0; j < n; ++j) w = w + A[i][j] * x[j];
      feasible = w >= -slack;
    }
    if (feasible) return true;
  }
  return false;
}

}  // namespace atwood::dynamics
