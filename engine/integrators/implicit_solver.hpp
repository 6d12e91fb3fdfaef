// Solves z = y0 + c g(t, z) to round-off: fixed-point sweeps while they contract fast, Newton otherwise.
#pragma once

#include <vector>

#include "math/dense_lu.hpp"
#include "protocol/solver_report.hpp"

namespace atwood {

template <class S> class ImplicitSolver {
 public:
  using Function = void (*)(void* context, S t_s, const S* z, S* g);

  explicit ImplicitSolver(int size);

  // z holds the first guess and receives the solution; g must be set (to 0) in every entry it does not compute.
  // False: neither iteration reached round-off. Allocates nothing.
  bool solve(Function g, void* context, S t_s, S c_s, const S* y0, S* z);
  // Report of the last solve(): all its iterations, and the change by the last one as residual.
  const SolveReport& report() const { return report_; }

 private:
  enum class Progress { solved, slow };
  Progress sweep(Function g, void* context, S t_s, S c_s, const S* y0, S* z);
  bool newton(Function g, void* context, S t_s, S c_s, const S* y0, S* z);
  void factor_jacobian(Function g, void* context, S t_s, S c_s, S* z);  // of I - c dg/dz, by differences; then LU
  S relative_size(const S* change, const S* z) const;
  bool end(SolveEnd ended, int iterations, S residual);  // false: capped

  int size_;
  std::vector<S> g_, change_, shifted_;
  DenseLu<S> lu_;
  SolveReport report_;
};

}  // namespace atwood
