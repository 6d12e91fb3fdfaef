// The slip path (hodograph) of an impact: the relative velocity at the point as a function of the normal impulse p.
//
//   u = u0 + K J,  J = (j_1, j_2, p),  axes t1, t2, n;  K the inverse mass matrix of the point: symmetric, positive
//                                                       definite
//   slip      dJ/dp = (-mu s, 1),  s = u_t / |u_t|
//   no slip   dJ/dp = (f, 1),      f = -K_tt^-1 K_tn: slip stays zero; possible where |f| <= mu
//   else      onset of slip along the s with K_tn - mu K_tt s = lambda s, lambda > 0: it keeps that direction
//
// Sources: Keller (1986); Bhatt and Koechling, J. Appl. Mech. 62 (1995) 893; Stronge, Impact Mechanics (2000), ch. 4;
// Batlle, J. Appl. Mech. 63 (1996) 168 for the renewed onset of slip.
#pragma once

#include "contact/impulse.hpp"
#include "protocol/solver_report.hpp"

namespace atwood {

// The impulse on b of the whole impact along t1, t2, n, for u0[2] < 0; or u0[2] = 0 for an impact without collision
// (impulse.hpp, collide_without_approach). solve: steps of turning slip and evaluations of its onset's direction;
// capped if one of them did not converge. Residual: error of the last step over the impulse; of a direction, the width
// of its bracket over the bracket it was sought in; infinity where the path has no end.
template <class S> struct SlipPath {
  S impulse_N_s[3];
  SolveReport solve;
};

template <class S> SlipPath<S> slip_path(const ImpactLaw<S>& law, const S (&K_per_kg)[3][3], const S (&u0_m_per_s)[3]);

}  // namespace atwood
