// A small linear complementarity problem, solved by trying every set of closed contacts (R. W. Cottle, J.-S. Pang and
// R. E. Stone, The Linear Complementarity Problem, 1992, section 1.1).
#pragma once

#include <cstddef>
#include <vector>

namespace atwood::dynamics {

// More contacts than this are too many sets.
inline constexpr std::size_t kMostTogether = 12;

// A x = b by Gaussian elimination with the largest pivot, at most kMostTogether unknowns. False: a pivot is not above
// `least` of the largest diagonal element; x then says nothing. S: double, long double or Wide.
template <class S>
bool eliminate(const std::vector<std::vector<S>>& A, const std::vector<S>& b, S least, std::vector<S>& x);

// w = A x + q, x >= 0, w >= 0, x_i w_i = 0, to `slack` in w. A is symmetric and positive semidefinite: w is the same
// for whichever set is found first. `least`: a smaller pivot, relative to the diagonal, is a dependent contact. False:
// no set fits, or there are more than most_together.
template <class S>
bool complementary(const std::vector<std::vector<S>>& A, const std::vector<S>& q, S slack, S least, std::vector<S>& x) {
  const std::size_t n = q.size();
  if (n > kMostTogether) return false;
  for (std::size_t set = 0; set < (std::size_t(1) << n); ++set) {
    std::vector<std::size_t> closed;
    for (std::size_t i = 0; i < n; ++i)
      if ((set >> i) & 1) closed.push_back(i);
    std::vector<std::vector<S>> part(closed.size(), std::vector<S>(closed.size()));
    std::vector<S> right, found;
    for (std::size_t i = 0; i < closed.size(); ++i) {
      right.push_back(-q[closed[i]]);
      for (std::size_t j = 0; j < closed.size(); ++j) part[i][j] = A[closed[i]][closed[j]];
    }
    if (!eliminate(part, right, least, found)) continue;
    x.assign(n, S(0));
    bool fits = true;
    for (std::size_t i = 0; i < closed.size(); ++i) {
      fits = fits && found[i] * A[closed[i]][closed[i]] >= -slack;
      x[closed[i]] = found[i] > 0 ? found[i] : S(0);
    }
    for (std::size_t i = 0; i < n && fits; ++i) {
      S w = q[i];
      for (std::size_t j = 0; j < n; ++j) w = w + A[i][j] * x[j];
      fits = w >= -slack;
    }
    if (fits) return true;
  }
  return false;
}

}  // namespace atwood::dynamics
