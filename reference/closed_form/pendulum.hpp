// The pendulum's equation theta'' = -w^2 sin theta, which also is that of a parallelogram of bars.
#pragma once

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

template <class S> struct Pendulum {
  S q0{}, theta0{};                         // coordinate and angle from the hanging position at t = 0
  S frequency{}, k{}, kc{}, u0{}, sign{1};  // of small swings; modulus; u at t = 0; +-1

  bool turns() const { return k > 1; }
  // q[0] = q0 + theta - theta0, and its derivatives.
  JointState<S> at(S t) const;
};

// A mechanism that turns by one angle about the unit vector n: its moment of inertia, its first moment at the start
// (mass times the centre's arm, all parts that turn) and gravity, both orthogonal to n and not zero.
template <class S>
Pendulum<S> swing(S inertia, const Vec<S>& first_moment_W, const Vec<S>& n, const Vec<S>& g, S q0, S rate);

}  // namespace atwood::closed_form
