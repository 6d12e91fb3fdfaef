#include "rigid/free_top.hpp"

namespace atwood {
namespace {

template <class S> struct Top { Quat<S> q_WP; Vec3<S> L_P; };  // P: principal axes

// The body turns by phi about its own axis k: q <- q exp(phi/2 e_k); momentum seen from the body turns back by phi.
template <class S, int k> void turn(Top<S>& top, S h_s, const Vec3<S>& moments) {
  S* L = &top.L_P.x;
  const S phi = h_s * L[k] / (&moments.x)[k];
  const S half_cos = real::cos(phi / S(2)), half_sin = real::sin(phi / S(2));
  Quat<S> step{half_cos, S(0), S(0), S(0)};
  (&step.x)[k] = half_sin;
  top.q_WP = top.q_WP * step;
  constexpr int i = (k + 1) % 3, j = (k + 2) % 3;
  const S c = half_cos * half_cos - half_sin * half_sin, s = S(2) * half_sin * half_cos;
  const S Li = L[i], Lj = L[j];
  L[i] = c * Li + s * Lj;
  L[j] = c * Lj - s * Li;
}

template <class S, class Flow>
void in_principal_axes(const MassProperties<S>& mass, Quat<S>& q_WB, Vec3<S>& w_WB_B, const Flow& flow) {
  const PrincipalAxes<S>& axes = mass.principal;
  const Vec3<S> I = axes.moments;
  Top<S> top{q_WB, w_WB_B};
  if (!axes.body_axes) {
    top.q_WP = q_WB * axes.q_BP;
    top.L_P = rotate_back(axes.q_BP, w_WB_B);
  }
  top.L_P = {I.x * top.L_P.x, I.y * top.L_P.y, I.z * top.L_P.z};
  flow(top, I);
  const Vec3<S> w_P{top.L_P.x / I.x, top.L_P.y / I.y, top.L_P.z / I.z};
  q_WB = axes.body_axes ? top.q_WP : top.q_WP * conjugate(axes.q_BP);
  w_WB_B = axes.body_axes ? w_P : rotate(axes.q_BP, w_P);
}

}  // namespace

template <class S> void free_top_strang(const MassProperties<S>& mass, S h_s, Quat<S>& q_WB, Vec3<S>& w_WB_B) {
  const S half_s = h_s / S(2);
  in_principal_axes(mass, q_WB, w_WB_B, [&](Top<S>& top, const Vec3<S>& I) {
    turn<S, 0>(top, half_s, I);
    turn<S, 1>(top, half_s, I);
    turn<S, 2>(top, h_s, I);
    turn<S, 1>(top, half_s, I);
    turn<S, 0>(top, half_s, I);
  });
}

template <class S> void free_top_lie(const MassProperties<S>& mass, S h_s, Quat<S>& q_WB, Vec3<S>& w_WB_B) {
  in_principal_axes(mass, q_WB, w_WB_B, [&](Top<S>& top, const Vec3<S>& I) {
    turn<S, 0>(top, h_s, I);
    turn<S, 1>(top, h_s, I);
    turn<S, 2>(top, h_s, I);
  });
}

template void free_top_strang<float>(const MassProperties<float>&, float, Quat<float>&, Vec3<float>&);
template void free_top_strang<double>(const MassProperties<double>&, double, Quat<double>&, Vec3<double>&);
template void free_top_strang<long double>(const MassProperties<long double>&, long double, Quat<long double>&,
                                           Vec3<long double>&);
template void free_top_strang<Quad>(const MassProperties<Quad>&, Quad, Quat<Quad>&, Vec3<Quad>&);
template void free_top_lie<float>(const MassProperties<float>&, float, Quat<float>&, Vec3<float>&);
template void free_top_lie<double>(const MassProperties<double>&, double, Quat<double>&, Vec3<double>&);
template void free_top_lie<long double>(const MassProperties<long double>&, long double, Quat<long double>&,
                                        Vec3<long double>&);
template void free_top_lie<Quad>(const MassProperties<Quad>&, Quad, Quat<Quad>&, Vec3<Quad>&);

}  // namespace atwood
