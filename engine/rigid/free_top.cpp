#include "rigid/free_top.hpp"

namespace atwood {
namespace {

// The body turns by phi about its own axis k: q <- q exp(phi/2 e_k); momentum seen from the body turns back by phi.
// With the rotation so far written 1 + a and this one 1 + b, b = (cos - 1, sin e_k): (1 + a)(1 + b) - 1 = a + b + a b.
template <class S, int k> void turn_about(S h_s, const Vec3<S>& g, const Vec3<S>& L_start, FreeTurn<S>& turn) {
  constexpr int i = (k + 1) % 3, j = (k + 2) % 3;
  S *dL = &turn.dw_B.x, *a = &turn.minus_one.x, &a_w = turn.minus_one.w;
  const S* L0 = &L_start.x;
  S sine, cosine;
  real::sin_cos(h_s * (L0[k] + dL[k]) * (&g.x)[k] / S(2), sine, cosine);
  const S square = sine * sine, minus_one = cosine < S(0) ? cosine - S(1) : -square / (S(1) + cosine);
  const S ai = a[i], aj = a[j], ak = a[k], w = a_w;
  a_w += minus_one + (w * minus_one - ak * sine);
  a[k] += sine + (w * sine + ak * minus_one);
  a[i] += ai * minus_one + aj * sine;
  a[j] += aj * minus_one - ai * sine;
  const S whole_minus_one = S(-2) * square, whole_sine = S(2) * sine * cosine;
  const S Li = L0[i] + dL[i], Lj = L0[j] + dL[j];
  dL[i] += whole_minus_one * Li + whole_sine * Lj;
  dL[j] += whole_minus_one * Lj - whole_sine * Li;
}

}  // namespace

template <class S> void split_turn(const Vec3<S>& g, S direct_s, S adjoint_s, const Vec3<S>& L, FreeTurn<S>& turn) {
  turn = {{S(0), S(0), S(0), S(0)}, {}};
  if (direct_s != S(0)) {
    turn_about<S, 0>(direct_s, g, L, turn);
    turn_about<S, 1>(direct_s, g, L, turn);
  }
  turn_about<S, 2>(direct_s + adjoint_s, g, L, turn);
  if (adjoint_s != S(0)) {
    turn_about<S, 1>(adjoint_s, g, L, turn);
    turn_about<S, 0>(adjoint_s, g, L, turn);
  }
}

template <class S>
bool free_turn(FreeTop top, const MassProperties<S>& mass, S direct_s, S adjoint_s, const Vec3<S>& w_WB_B,
               FreeTurn<S>& turn) {
  const PrincipalAxes<S>& axes = mass.principal;
  const Vec3<S> I = axes.moments, g{S(1) / I.x, S(1) / I.y, S(1) / I.z};
  const Vec3<S> w_P = axes.body_axes ? w_WB_B : rotate_back(axes.q_BP, w_WB_B);
  const Vec3<S> L{I.x * w_P.x, I.y * w_P.y, I.z * w_P.z};
  bool solved = true;
  if (top == FreeTop::splitting) split_turn(g, direct_s, adjoint_s, L, turn);
  else if (top == FreeTop::exact) exact_turn(g, direct_s + adjoint_s, L, turn);
  else solved = implicit_turn(top, I, direct_s + adjoint_s, L, turn);
  turn.dw_B = {g.x * turn.dw_B.x, g.y * turn.dw_B.y, g.z * turn.dw_B.z};
  if (!axes.body_axes) {
    turn.dw_B = rotate(axes.q_BP, turn.dw_B);
    const Vec3<S> u = rotate(axes.q_BP, Vec3<S>{turn.minus_one.x, turn.minus_one.y, turn.minus_one.z});
    turn.minus_one = {turn.minus_one.w, u.x, u.y, u.z};
  }
  return solved;
}

#define ATWOOD_INSTANTIATE(S)                                                      \
  template void split_turn<S>(const Vec3<S>&, S, S, const Vec3<S>&, FreeTurn<S>&); \
  template bool free_turn<S>(FreeTop, const MassProperties<S>&, S, S, const Vec3<S>&, FreeTurn<S>&);
ATWOOD_INSTANTIATE(float)
ATWOOD_INSTANTIATE(double)
ATWOOD_INSTANTIATE(long double)
ATWOOD_INSTANTIATE(Quad)
#undef ATWOOD_INSTANTIATE

}  // namespace atwood
