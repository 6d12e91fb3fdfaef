// The extremal eigenvalues of a rate's derivative at a state: those that bound the steps of a method.
#pragma once

#include <complex>
#include <vector>

#include "math/system.hpp"

namespace atwood::fluid {

struct Spectrum {
  std::vector<std::complex<double>> eigenvalues;  // 1/s
  double residual = 0;  // of the pair with the largest modulus, |J v - lambda v| / (|lambda| |v|)
};

// Ritz values of df/dy at (t_s, y) by `dimension` steps of Arnoldi's method (Arnoldi 1951; Saad, Numerical Methods for
// Large Eigenvalue Problems, 2nd ed., section 6.2). Extremal eigenvalues converge first; the residual says how far. The
// derivative acts by differences of the rate: `scale` has the size of a small change of each unknown (system.size
// numbers above 0). No eigenvalues if a rate is not finite, or if those of the Hessenberg matrix were not found.
Spectrum extremal_eigenvalues(System<double>& system, double t_s, const double* y, const std::vector<double>& scale,
                              int dimension);

}  // namespace atwood::fluid
