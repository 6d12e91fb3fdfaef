// Extrapolation of Gragg's midpoint rule (Gragg, Bulirsch, Stoer).
#pragma once

#include "integrators/compensation.hpp"
#include "integrators/stepper.hpp"

namespace atwood {

inline constexpr int kMostColumns = 12;

// With n_j = 2, 4, 6, ... substeps H = h / n_j, from d_0 = 0, d_1 = H f(t, y):
//   d_(i+1) = d_(i-1) + 2 H f(t + i H, y + d_i),   T_j1 = d_(n_j)
// has an error expansion in h^2 (Gragg 1965), so
//   T_jk = T_j(k-1) + (T_j(k-1) - T_(j-1)(k-1)) / ((n_j / n_(j-k+1))^2 - 1)
// is of order 2 k. The last one, T_kk, is the result; its difference from T_k(k-1) is the error estimate. Hairer,
// Norsett, Wanner, Solving ODEs I, eq. II.9.10 and II.9.13, without the smoothing step.
template <class S> class Extrapolation final : public Stepper<S> {
 public:
  Extrapolation(System<S>& system, int columns, bool compensated);

  bool step(S t_s, S h_s, const S* y, S* y_new) override;
  S error_norm(S rtol, S atol) const override;
  int estimate_order() const override { return 2 * columns_ - 2; }

 private:
  void midpoints(S t_s, S h_s, const S* y, int substeps, S* increment);

  int columns_, size_;
  Compensation<S> compensation_;
  std::vector<S> rate_start_, rate_, before_, state_, difference_;
  std::vector<S> row_[kMostColumns];  // T_j1, T_j2, ... of the last j, from row_[j - 1] down to row_[0]
};

}  // namespace atwood
