// Impulses of several points at once by Newton's method, where projected Gauss-Seidel converges too slowly.
//
// The laws of impact_problem.hpp as equations, with the relative velocities u = u_0 + W x of the impulses x = (p, t),
// W = J M^-1 J^T, and the inverse effective masses W_n, W_t of a point:
//   p - max(least, p - (v_n - target) / W_n) = 0
//   t - [t - u_t / W_t] on the disk of radius mu p = 0
// Their derivatives, one-sided at the kinks, give a semismooth Newton iteration. Source: Alart and Curnier, Comp. Meth.
// Appl. Mech. Engng 92 (1991) 353.
#pragma once

#include <vector>

#include "contact/event/impact_problem.hpp"

namespace atwood::event {

// From the impulses of points [first, first + count), which need inverse masses, targets and least impulses: improves
// them, and applies the change to the bodies' velocities. Residual: the largest left side of the equations above
// relative to the largest normal impulse; converged: at most 64 roundings. Where the iteration does not reduce the
// residual that it begins with, nothing changes.
template <class S>
SolveReport refine_impulses(ImpactProblem<S>& problem, std::vector<ImpactPoint<S>>& points, int first, int count);

}  // namespace atwood::event
