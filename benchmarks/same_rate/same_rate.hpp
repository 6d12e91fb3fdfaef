// The in-house engine's general methods on the reference's own equations: "atwood-same-rate/rk4" and others, for
// comparisons with methods of odeint, ARKODE and CVODE.
//
// Natively each side evaluates its own right-hand side, and a ratio of times compares these as well as the methods.
// Here both evaluate the one of reference/dynamics, through the one callable of reference/stepping
// (Equations::rate, a std::function), which is compiled once and linked into every worker; refusals, samples, counts of
// evaluations and the clock are those of reference/stepping. States have the layout of the reference, quaternions
// are not normalised, and rates are evaluated one at a time, without fused loops: a caller who gives our steppers
// another right-hand side gets the same.
//
// Truth and engine share no code: neither room includes the other, and this one, to the right of both, joins them.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// In double and long double. Methods that need more than a rate (positions and velocities apart, energies, power
// series, rotations) are left out.
Engine same_rate_engine();

}  // namespace atwood
