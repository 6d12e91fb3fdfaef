// Principal moments and axes of an inertia matrix.
#pragma once

#include "closed_form/number.hpp"

namespace atwood::closed_form {

template <class S> struct PrincipalAxes {
  std::array<S, 3> moment{};  // ascending
  Quat<S> q_BP{1, 0, 0, 0};   // principal axes to body axes
};

// A diagonal matrix is only reordered; any other symmetric matrix is diagonalised. Moments that are not numbers: 60
// sweeps of rotations did not converge.
template <class S> PrincipalAxes<S> principal_axes(const Real33& inertia);
template <class S> PrincipalAxes<S> principal_axes_of(const std::array<S, 9>& inertia);

}  // namespace atwood::closed_form
