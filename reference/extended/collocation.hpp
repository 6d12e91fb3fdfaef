// Gauss-Legendre collocation with 10 stages, order 20 (Butcher 1964; Hairer, Norsett and Wanner I, section II.7;
// Hairer, Lubich and Wanner, Geometric Numerical Integration, section II.1.3).
#pragma once

#include <array>

#include "extended/problem.hpp"

namespace atwood::extended {

inline constexpr int kStages = 10;

// On [0, 1]: nodes c, weights b, A[i][j] = integral from 0 to c_i of the j-th Lagrange polynomial. Computed in quad.
struct GaussTableau {
  std::array<Wide, kStages> c, b;
  std::array<std::array<Wide, kStages>, kStages> A;
  std::array<Wide, kStages> half;  // integrals from 0 to 1/2
  // Weights that give the Legendre coefficients of degree 8 and 9 of the polynomial through values at the nodes.
  std::array<double, kStages> degree8, degree9;
};
const GaussTableau& gauss_tableau();

// The stage equations F_i = f(y + h sum_j A_ij F_j) are solved to round-off in quad: first by fixed-point iteration in
// double, then by iterative refinement, in which the residual is computed in quad and the linearised equations are
// solved in double with a difference quotient for the derivative. Each pass gains about eight digits. A step whose
// stage equations do not converge is rejected and repeated with a smaller step.
//
// A system may be so conditioned that its rates lose digits: a light body between heavy ones, in maximal coordinates,
// loses as many as the ratio of the masses has. The stage equations then stagnate above the round-off of their
// arithmetic. When a step is rejected, the loss is measured on the rates in double, and iterations that stagnate at the
// round-off that follows from it count as converged.
class Collocation : public Stepper<Wide> {
 public:
  // stage_residual: relative to the state's scale, at which the stage equations count as solved. Each power of 1e-8
  // costs one evaluation of all stages in quad.
  Collocation(const Problem& problem, Wide tolerance, double stage_residual = 1e-31);
  Wide step(Wide t, Wide* y, Wide limit) override;
  DenseStep<Wide> dense() override;
  void raise_scale(const Wide* sizes) override { scale_.include(sizes); }

 private:
  bool solve_narrow(double t, double h);
  bool solve_stages(Wide t, const Wide* y, Wide h);
  void correct(double t, double h, const std::vector<double>& residual);
  double error(double h) const;
  void measure_loss(Wide t, const Wide* y, double h);

  Problem problem_;
  Wide tolerance_;
  double stage_residual_;
  double loss_ = 1;  // round-off of the rates in double, relative to the largest, in units of that of double; 1: little
  Wide proposal_ = 0;
  Scale<Wide> scale_;
  std::vector<Wide> Y_, F_, rate_;                                     // stages x size
  std::vector<double> y0_, y_, f_, d_, rates_at_guess_, stage_shift_;  // the same in double
  std::vector<double> scale_double_;                                   // scale of each component
  DenseStep<Wide> last_;                                               // its ends alone
};

}  // namespace atwood::extended
