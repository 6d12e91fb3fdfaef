// Principal axes of a symmetric 3x3 matrix.
#pragma once

#include <array>

#include "math/quat.hpp"

namespace atwood {

// I = R(q_BP) diag(moments) R(q_BP)^T: q_BP turns principal axes P into body axes B. A diagonal matrix keeps its axes
// and its order exactly (q_BP = identity, no rounding).
template <class S> struct PrincipalAxes {
  Vec3<S> moments;
  Quat<S> q_BP;
  bool body_axes = true;  // q_BP is the identity
};

// Cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, 4th ed., section 8.5), carried as quaternions.
// Moments that are not numbers: 30 sweeps did not converge.
template <class S> PrincipalAxes<S> principal_axes(const std::array<double, 9>& inertia_kg_m2);

}  // namespace atwood
