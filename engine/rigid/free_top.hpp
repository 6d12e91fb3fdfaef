// The free rotation of a body over a step, by splitting: the drift of partitioned methods.
#pragma once

#include "rigid/model.hpp"

namespace atwood {

// With body momentum L = I w in principal axes, H = sum L_i^2 / (2 I_i); the flow of each term alone is a rotation
// about one axis by the angle h L_i / I_i. Every composition keeps |L|, and q L q* in the world, to round-off.
//
// Strang: R1(h/2) R2(h/2) R3(h) R2(h/2) R1(h/2), symmetric, order 2 (McLachlan and Reich; Dullweber, Leimkuhler and
// McLachlan, J. Chem. Phys. 107 (1997) 5840, eq. 24). Lie: R1(h) R2(h) R3(h), order 1.
template <class S> void free_top_strang(const MassProperties<S>& mass, S h_s, Quat<S>& q_WB, Vec3<S>& w_WB_B);
template <class S> void free_top_lie(const MassProperties<S>& mass, S h_s, Quat<S>& q_WB, Vec3<S>& w_WB_B);

}  // namespace atwood
