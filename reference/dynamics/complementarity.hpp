// A small linear complementarity problem, solved by trying every set of closed contacts (R. W. Cottle, J.-S. Pang and
// R. E. Stone, The Linear Complementarity Problem, 1992, section 1.1).
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace atwood::dynamics {

// More contacts than this are too many sets.
inline constexpr std::size_t kMostTogether = 12;

// A x = b by elimination with the largest pivot; false where that is below `least` of the largest diagonal.
template <class S> bool eliminate(std::vector<std::vector<S>> A, std::vector<S> b, S least, std::vector<S>& x) {
  const auto size = [](S v) { return v < 0 ? -v : v; };
  const std::size_t n = b.size();
  S largest = 0;
  for (std::size_t i = 0; i < n; ++i) largest = A[i][i] > largest ? A[i][i] : largest;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t at = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (size(A[i][k]) > size(A[at][k])) at = i;
    if (!(size(A[at][k]) > least * largest)) return false;
    std::swap(A[k], A[at]);
    std::swap(b[k], b[at]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const S factor = A[i][k] / A[k][k];
      for (std::size_t j = k; j < n; ++j) A[i][j] = A[i][j] - factor * A[k][j];
      b[i] = b[i] - factor * b[k];
    }
  }
  x.assign(n, S(0));
  for (std::size_t k = n; k-- > 0;) {
    x[k] = b[k];
    for (std::size_t j = k + 1; j < n; ++j) x[k] = x[k] - A[k][j] * x[j];
    x[k] = x[k] / A[k][k];
  }
  return true;
}

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
