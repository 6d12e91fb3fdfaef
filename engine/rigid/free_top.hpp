// The free rotation of a body over a step: the drift of partitioned methods.
#pragma once

#include "protocol/solver_report.hpp"
#include "rigid/model.hpp"

namespace atwood {

// With body momentum L = I w in principal axes, H = sum L_i^2 / (2 I_i). Each of these methods conserves q L q*, the
// momentum in world axes, and so |L|, to round-off.
enum class FreeTop {
  // The flow of each term of H alone is a rotation about one principal axis by h L_i / I_i. Over `direct` they come in
  // the order 1 2 3, over `adjoint`, which follows, in the order 3 2 1: each of order 1 and the other's adjoint, both
  // together with equal parts the symmetric Strang splitting, order 2 (McLachlan, Physica D 66 (1993) 12; Reich,
  // Physica D 76 (1994) 375; Dullweber, Leimkuhler and McLachlan, J. Chem. Phys. 107 (1997) 5840, eq. 24).
  splitting,
  // The discrete Lagrangian top, symmetric, order 2 (Moser and Veselov, Commun. Math. Phys. 139 (1991) 217; in
  // Cayley's vector: Lee, Leok and McClamroch, Comput. Methods Appl. Mech. Eng. 196 (2007) 2907, eq. 36).
  moser_veselov,
  // The implicit midpoint rule for L, attitude by Cayley's map of the same rate: symmetric, order 2, keeps H too
  // (Austin, Krishnaprasad and Wang, J. Comput. Phys. 107 (1993) 105).
  midpoint,
  // Jacobi's elliptic functions: exact (van Zon and Schofield, J. Comput. Phys. 225 (2007) 145).
  exact,
};

// What a step does: q_WB becomes q_WB (1 + minus_one), and the body rate gains dw_B. Both are formed as increments, so
// that their round-off shrinks with the step; for FreeTop::exact it is relative to the whole rotation.
template <class S> struct FreeTurn {
  Quat<S> minus_one;
  Vec3<S> dw_B;
  SolveReport solve = {};  // of the implicit methods; 0 iterations: no equation was solved
};

// Over direct_s + adjoint_s. False: the step's implicit equations were not solved.
template <class S>
bool free_turn(FreeTop top, const MassProperties<S>& mass, S direct_s, S adjoint_s, const Vec3<S>& w_WB_B,
               FreeTurn<S>& turn);

// ---- in principal axes: `turn` receives dL in place of dw; g = 1 / I.
template <class S> void split_turn(const Vec3<S>& g, S direct_s, S adjoint_s, const Vec3<S>& L, FreeTurn<S>& turn);
template <class S> bool implicit_turn(FreeTop top, const Vec3<S>& I, S h_s, const Vec3<S>& L, FreeTurn<S>& turn);
template <class S> void exact_turn(const Vec3<S>& g, S h_s, const Vec3<S>& L, FreeTurn<S>& turn);

}  // namespace atwood
