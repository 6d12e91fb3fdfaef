// Solves the stage equations of implicit methods to the round-off of the scalar.
#pragma once

#include <vector>

#include "math/dense_lu.hpp"
#include "protocol/solver_report.hpp"

namespace atwood {

// For increments z_i = Y_i - y (Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., VIII.6: their
// round-off is that of z, not that of y):
//
//   z_i = known_i + h sum_j a_ij k_j,   k_j = the rate at stage j, a function of z_j alone
//
// Fixed-point sweeps while they contract fast; otherwise simplified Newton iteration on these same equations, with
// Jacobians of the stages by differences. The Jacobians affect only the convergence: both iterations end when the
// equations themselves hold to round-off (a change that is 0, that would be followed by less than a thousandth of an
// ulp, or that no longer shrinks among the last digits), so no tolerance of the solver enters the order of a method.
//
// Component i of stage s is z[i * stages + s]; k and known likewise, as in System::rates.
template <class S> class StageSolver {
 public:
  using Rates = void (*)(void* context, const S* z, S* k);

  StageSolver(int size, std::vector<Quad> a);  // a row-major, stages x stages, not singular

  // z holds the first guess. True: z and k solve the equations. y only sets the scale of z. Allocates
  // nothing.
  bool solve(Rates rates, void* context, S h_s, const S* y, const S* known, S* z, S* k);
  int stages() const { return stages_; }
  // Report of the last solve(): all its iterations and the residual. An iteration whose changes no longer shrink is
  // `stagnated` within 256 (sweeps) or 4096 (Newton) roundings, `capped` above.
  const SolveReport& report() const { return report_; }
  // Whether the last solve() used Newton's method; if so, d rate_i / d z_c of a stage.
  bool took_newton() const { return took_newton_; }
  S jacobian(int stage, int i, int c) const { return jacobian_[(i * size_ + c) * stages_ + stage]; }

 private:
  enum class Progress { solved, slow, failed };
  Progress sweep(S* z, S* k);
  Progress newton(S* z, S* k);
  void evaluate_right_side(const S* k, S* right) const;  // known + h A k
  void factor_jacobian(S* z, const S* k);
  S relative_size(const S* change, const S* z) const;
  Progress end(Progress progress, SolveEnd ended, int iterations, S residual);

  static constexpr int largest_newton = 2048;  // unknowns; above, only sweeps

  int size_, stages_;
  std::vector<S> a_, a_inverse_;
  std::vector<S> guess_, right_, change_, shifted_, held_, jacobian_;
  DenseLu<S> lu_;
  bool took_newton_ = false;
  SolveReport report_;
  // of the present call
  Rates rates_ = nullptr;
  void* context_ = nullptr;
  S h_s_{};
  const S *y_ = nullptr, *known_ = nullptr;
};

}  // namespace atwood
