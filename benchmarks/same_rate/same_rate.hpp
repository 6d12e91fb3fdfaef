// The in-house engine's general methods on the reference's own equations: "atwood-same-rate/rk4" and its like, for
// comparisons of methods with those of odeint, ARKODE and CVODE.
//
// Natively each side evaluates its own right-hand side, and a ratio of times compares those as much as the methods. Here
// both evaluate the one of reference/dynamics, through the one callable of reference/stepping
// (Equations::rate, a std::function), which is compiled once and linked into every worker; refusals, samples, counts of
// evaluations and the clock are reference/stepping's too. States are laid out as the reference lays them out, quaternions
// are not normalised, nothing is fused, and no batch of rates is evaluated at once: what a caller of our steppers with a
// right-hand side of his own would get.
//
// Truth and engine share no code: neither room includes the other, and this one, to the right of both, joins them.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// In double and long double. Methods that need more than a rate (positions and velocities apart, energies, power series,
// rotations) are left out.
Engine same_rate_engine();

}  // namespace atwood
