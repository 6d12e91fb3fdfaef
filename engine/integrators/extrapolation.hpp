// Extrapolation of Gragg's midpoint rule (Gragg, Bulirsch, Stoer).
#pragma once

#include "integrators/adaptive.hpp"
#include "integrators/compensation.hpp"
#include "integrators/stepper.hpp"

namespace atwood {

inline constexpr int kMaxColumns = 12;
// With a tolerance and a fixed order: the differences of later columns are lost in round-off, and steps become tiny.
inline constexpr int kMaxFixedColumns = 8;

struct ExtrapolationOptions {
  int columns = 6;  // of equal steps, and with a tolerance where the order is not chosen
  bool compensated = false;
  bool choose_order = false;  // with a tolerance: as many columns as cost least for the length of the step
  StepLimits limits = {};
};

// With n_j = 2, 4, 6, ... substeps H = h / n_j, from d_0 = 0, d_1 = H f(t, y):
//   d_(i+1) = d_(i-1) + 2 H f(t + i H, y + d_i),   T_j1 = d_(n_j)
// has an error expansion in h^2 (Gragg 1965), so
//   T_jk = T_j(k-1) + (T_j(k-1) - T_(j-1)(k-1)) / ((n_j / n_(j-k+1))^2 - 1)
// is of order 2 k. The last one, T_kk, is the result; its difference from T_k(k-1) is the error estimate. Hairer,
// Norsett, Wanner, Solving ODEs I, eq. II.9.10 and II.9.13, without the smoothing step.
//
// A chosen order follows section II.9, "Order and Step Size Control", and its code ODEX: a step expects to converge in
// column k and may end in k - 1 or k + 1; the next one takes the column of the least work per unit step
//   W_j = A_j / H_j,   A_j = 1 + sum (n_i - 1), i <= j,   H_j = h safety err_j^(-1/(2 j - 1)).
template <class S> class Extrapolation final : public Stepper<S> {
 public:
  Extrapolation(System<S>& system, const ExtrapolationOptions& options);

  bool step(S t_s, S h_s, const S* y, S* y_new) override;
  S error_norm(S rtol, S atol) const override;
  int estimate_order() const override { return 2 * options_.columns - 2; }

  bool chooses_steps() const override { return options_.choose_order; }
  bool takes_any_tolerance() const override { return false; }
  void set_tolerance(S rtol, S atol) override;
  typename Stepper<S>::Advice advise(S rtol, S atol) override;

 private:
  void midpoints(S t_s, S h_s, const S* y, int substeps, S* increment);
  void add_column(S t_s, S h_s, const S* y, int column);
  void columns_to_tolerance(S t_s, S h_s, const S* y);
  double norm(const S* y, const S* y_new, S rtol, S atol) const;
  double factor(int column) const;
  double work(int column) const;

  const ExtrapolationOptions options_;
  int size_;
  Compensation<S> compensation_;
  std::vector<S> rate_start_, rate_, before_, state_, difference_;
  std::vector<S> row_[kMaxColumns];  // T_j1, T_j2, ... of the last j, from row_[j - 1] down to row_[0]
  // Of a chosen order; columns count from 1.
  S rtol_{}, atol_{};  // 0: equal steps
  int expected_ = 0, reached_ = 0;
  bool converged_ = false, rejected_before_ = false;
  double error_[kMaxColumns + 1] = {};  // of each column of the last step; 1 is the tolerance
};

}  // namespace atwood
