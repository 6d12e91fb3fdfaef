// Least squares by monomials: their powers, and Cholesky's factor of the normal equations.
#pragma once

#include <vector>

#include "fluid_truth/number.hpp"

namespace atwood::fluid_truth {

struct Monomial {
  int power[3] = {0, 0, 0};
  int degree() const { return power[0] + power[1] + power[2]; }
};

// All monomials of degree `least` .. P in d variables, by descending degree.
inline std::vector<Monomial> monomials(int d, int P, int least) {
  std::vector<Monomial> made;
  for (int degree = P; degree >= least; --degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= 0; --b) {
        const int e = degree - a - b;
        if (d == 3 || e == 0) made.push_back({{a, b, e}});
      }
  return made;
}

template <class S> S raised(S x, int n) {
  S made = 1;
  for (int k = 0; k < n; ++k) made *= x;
  return made;
}

// Cholesky's factor of a symmetric positive matrix scaled to a unit diagonal, and solutions by it. M: n by n, its lower
// triangle, row after row. Not regular: a pivot is below `least_pivot` of its diagonal element.
template <class S> class Fit {
 public:
  Fit(const std::vector<S>& M, int n, double least_pivot) : n_(n), scale_(n), L_(M) {
    for (int k = 0; k < n; ++k) {
      if (!(M[k * n + k] > 0)) return;
      scale_[k] = 1 / sqrt(M[k * n + k]);
    }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j <= i; ++j) {
        S sum = M[i * n + j] * scale_[i] * scale_[j];
        for (int k = 0; k < j; ++k) sum -= L_[i * n + k] * L_[j * n + k];
        if (i == j) {
          if (!(sum >= S(least_pivot))) return;
          L_[i * n + i] = sqrt(sum);
        } else {
          L_[i * n + j] = sum / L_[j * n + j];
        }
      }
    regular_ = true;
  }
  bool regular() const { return regular_; }
  std::vector<S> solve(const std::vector<S>& b) const {
    std::vector<S> x(n_);
    for (int i = 0; i < n_; ++i) {
      S sum = b[i] * scale_[i];
      for (int k = 0; k < i; ++k) sum -= L_[i * n_ + k] * x[k];
      x[i] = sum / L_[i * n_ + i];
    }
    for (int i = n_ - 1; i >= 0; --i) {
      S sum = x[i];
      for (int k = i + 1; k < n_; ++k) sum -= L_[k * n_ + i] * x[k];
      x[i] = sum / L_[i * n_ + i];
    }
    for (int i = 0; i < n_; ++i) x[i] *= scale_[i];
    return x;
  }

 private:
  int n_;
  std::vector<S> scale_, L_;
  bool regular_ = false;
};

}  // namespace atwood::fluid_truth
