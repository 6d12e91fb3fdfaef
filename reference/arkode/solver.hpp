// An ARKODE integrator as a Stepper. Its users need no SUNDIALS header.
#pragma once

#include "arkode/tables.hpp"
#include "stepping/stepping.hpp"

namespace atwood::arkode {

// Equal steps: `by_tolerance` is false; rtol and atol are then used in the nonlinear solver's stopping test only.
struct Options {
  Scheme scheme;
  bool by_tolerance = false;
  double rtol = 1e-10, atol = 1e-12;
  std::int64_t max_steps = 2000000;  // of a whole run
  double nonlinear_coefficient =
      0.1;                        // Newton's iteration stops when the weighted norm of its correction is below this
  int nonlinear_iterations = 0;   // 0: 20 at equal steps, ARKODE's default (3) otherwise
  double nonlinear_crdown = 0.3;  // ARKODE's default; the factor by which a stage's rate of convergence is remembered
  int rate_repeats = 1;           // how often each rate is evaluated
};

// The weights of Newton's stopping test at fixed steps: corrections smaller than a part in 1e14 of the state end it,
// under the truncation error of every rung that an order is read from and above the round-off of a difference-quotient
// solve.
inline constexpr double kFixedRtol = 1e-13, kFixedAtol = 1e-15;

std::unique_ptr<stepping::Stepper<double>> make_solver(const Options& options,
                                                       const stepping::Equations<double>& equations,
                                                       const std::vector<double>& y, double h_s);

}  // namespace atwood::arkode
