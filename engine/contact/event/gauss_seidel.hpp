// Contact forces by projected Gauss-Seidel iteration.
#pragma once

#include "contact/event/constraints.hpp"

namespace atwood::event {

// Computes normal forces, friction and couples of active.contacts, and their relative accelerations u_dot and alpha;
// `free_dydt`: the rates without contacts. Of contacts at the onset of slip, friction opposes the slip at the end of a
// step of 1 / inverse_step_per_s (0: the slip's acceleration alone decides), whose direction becomes slip_direction.
// Residual: the last sweep's largest change of a force relative to the largest normal force; converged: to 2 eps.
template <class S>
SolveReport solve_forces_gauss_seidel(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                                      ConstraintSystem<S>& constraints, const S* free_dydt, S inverse_step_per_s);

}  // namespace atwood::event
