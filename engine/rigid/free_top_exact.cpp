// The exact flow of the free top.
//
// Body momentum in principal axes, g_i = 1 / I_i, L_i' = (g_k - g_j) L_j L_k. With axis 3 the extreme one that L
// circles, axis 2 the middle one and axis 1 the other extreme (van Zon and Schofield, J. Comput. Phys. 225 (2007) 145,
// section 3):
//   L_1 = p cn u,  L_2 = q sn u,  L_3 = +-r dn u,   u' = +-rate
//   A = 2E - g3 L^2 = (g1 - g3) L1^2 + (g2 - g3) L2^2,   p^2 = A / (g1 - g3),  q^2 = A / (g2 - g3)
//   B = g1 L^2 - 2E = (g1 - g2) L2^2 + (g1 - g3) L3^2,   r^2 = B / (g1 - g3),  rate^2 = B (g2 - g3)
//   C = g2 L^2 - 2E = (g2 - g1) L1^2 + (g2 - g3) L3^2,   k'^2 = (g1 - g3) C / ((g2 - g3) B)
// The sums of A and B do not cancel; C's sign says which extreme axis is circled.
//
// The third angle: the body's axis a turns about L, seen from the world, at psi' = L (2E - g_a L_a^2) / (L^2 - L_a^2).
// The axis a is 1 or 3, whichever stays farther from L:
//   a = 1, A <= B:  psi' = L (g3 + (g1 - g3) N s^2 / (1 + N s^2)),  N = A / B,                     s = sn u
//   a = 3, A > B:   psi' = L (g1 - (g1 - g3) N s^2 / (1 + N s^2)),  N = (g1 - g2) / (g2 - g3)
// and int N s^2 / (1 + N s^2) du = N s^3 R_J(cn^2, dn^2, 1, 1 + N s^2) / 3 on a quarter period (DLMF 19.25.14).
#include "math/elliptic.hpp"
#include "math/so3.hpp"
#include "rigid/free_top.hpp"

namespace atwood {
namespace {

struct Axes {
  int one, two, three;
};

template <class S> S part(const Vec3<S>& v, int i) { return (&v.x)[i]; }
template <class S> S square(S x) { return x * x; }

// Axes sorted by g; the first and third are exchanged unless L circles the third.
template <class S> Axes choose_axes(const Vec3<S>& g, const Vec3<S>& L) {
  Axes a{0, 1, 2};
  const auto order = [&](int& i, int& j) {
    if (part(g, j) < part(g, i)) {
      const int k = i;
      i = j;
      j = k;
    }
  };
  order(a.one, a.two);
  order(a.two, a.three);
  order(a.one, a.two);
  const S C = (part(g, a.two) - part(g, a.one)) * square(part(L, a.one)) +
              (part(g, a.two) - part(g, a.three)) * square(part(L, a.three));
  return C <= S(0) ? a : Axes{a.three, a.two, a.one};  // g2 - g3 < 0 here
}

// cos and sin of half the angle whose direction is (x, y).
template <class S> void half_angle(S x, S y, S& cosine, S& sine) {
  const S length = real::sqrt(x * x + y * y);
  if (x >= S(0)) {
    cosine = real::sqrt((length + x) / (S(2) * length));
    sine = y / (S(2) * length * cosine);
  } else {
    sine = (y < S(0) ? S(-1) : S(1)) * real::sqrt((length - x) / (S(2) * length));
    cosine = y / (S(2) * length * sine);
  }
}

// The rotation that takes body axis a to L and keeps axis a, L and the image of axis b = a + 1 in one plane:
// by beta about a, where L_b : L_c = cos beta : sin beta, after theta about c = a + 2, where cos theta = L_a / |L|.
template <class S> Quat<S> alignment(int a, const Vec3<S>& L) {
  const int b = (a + 1) % 3, c = (a + 2) % 3;
  Quat<S> about_a, about_c;
  const S side = real::sqrt(square(part(L, b)) + square(part(L, c)));
  half_angle(part(L, b), part(L, c), about_a.w, (&about_a.x)[a]);
  half_angle(part(L, a), side, about_c.w, (&about_c.x)[c]);
  return about_a * about_c;
}

// Phase of the motion: elliptic functions, the argument they belong to in [-K, K], the integral above.
template <class S> struct Phase { S sn, cn, dn, u, integral; };

template <class S> S quarter_integral(S N, S sn, S cn, S dn) {
  return N * sn * sn * sn * carlson_rj(cn * cn, dn * dn, S(1), S(1) + N * sn * sn) / S(3);
}

// The phase after du. Half periods of 2 K turn the signs of sn and cn and add twice the integral over a quarter.
template <class S> Phase<S> advance(const Phase<S>& start, S du, S complement, S N, S& sign) {
  const JacobiFunctions<S> jacobi(complement);
  const S K = jacobi.quarter();
  S u = start.u + du;
  S halves = S(0);
  if (real::abs(u) > K) {
    halves = real::floor(u / (S(2) * K) + S(0.5));
    u -= S(2) * K * halves;
    if (real::floor(halves / S(2)) * S(2) != halves) sign = -sign;
  }
  const auto f = jacobi.at(real::max(-K, real::min(K, u)));
  S integral = quarter_integral(N, f.sn, f.cn, f.dn);
  if (halves != S(0)) integral += S(2) * halves * quarter_integral(N, S(1), S(0), real::sqrt(complement));
  return {f.sn, f.cn, f.dn, u, integral};
}

}  // namespace

template <class S> void exact_turn(const Vec3<S>& g, S h_s, const Vec3<S>& L, FreeTurn<S>& turn) {
  const Axes axes = choose_axes(g, L);
  const S g1 = part(g, axes.one), g2 = part(g, axes.two), g3 = part(g, axes.three);
  const S L1 = part(L, axes.one), L2 = part(L, axes.two), L3 = part(L, axes.three);
  const S A = (g1 - g3) * L1 * L1 + (g2 - g3) * L2 * L2, B = (g1 - g2) * L2 * L2 + (g1 - g3) * L3 * L3;
  const bool on_axis = (L1 == S(0)) + (L2 == S(0)) + (L3 == S(0)) >= 2;
  if (on_axis || A == S(0) || B == S(0) || g2 == g3) {
    turn = {so3_exp_minus_one(h_s * Vec3<S>{g.x * L.x, g.y * L.y, g.z * L.z}), {}};
    return;
  }
  const S C = (g2 - g1) * L1 * L1 + (g2 - g3) * L3 * L3;
  const S p = real::sqrt(A / (g1 - g3)), q = real::sqrt(A / (g2 - g3)), r = real::sqrt(B / (g1 - g3));
  const S least = square(real::epsilon<S>());  // on the separatrix the period is infinite; 4 ln(4 / epsilon) is used
  const S complement = real::max(least, real::min(S(1), (g1 - g3) * C / ((g2 - g3) * B)));
  // u' has the sign of L3 (g1 - g3), reversed where the three axes are an odd permutation (left-handed).
  const bool even = (axes.one + 1) % 3 == axes.two;
  const bool backward = (L3 < S(0)) != (g1 < g3);
  const S rate = (backward == even ? S(-1) : S(1)) * real::sqrt(B * (g2 - g3));

  S sign = L1 < S(0) ? S(-1) : S(1);  // cn < 0: half a period earlier
  Phase<S> start{sign * L2 / q, sign * L1 / p, real::abs(L3) / r, S(0), S(0)};
  const bool about_one = real::abs(A) <= real::abs(B);
  const S N = about_one ? A / B : (g1 - g2) / (g2 - g3);
  start.u = start.sn * carlson_rf(square(start.cn), square(start.dn), S(1));
  start.integral = quarter_integral(N, start.sn, start.cn, start.dn);
  const Phase<S> end = advance(start, rate * h_s, complement, N, sign);

  Vec3<S> L_new;
  (&L_new.x)[axes.one] = sign * p * end.cn;
  (&L_new.x)[axes.two] = sign * q * end.sn;
  (&L_new.x)[axes.three] = (L3 < S(0) ? -r : r) * end.dn;
  const S extra = (g1 - g3) * (end.integral - start.integral) / rate;
  const S half_psi = norm(L) * (about_one ? g3 * h_s + extra : g1 * h_s - extra) / S(2);

  // The attitude, up to a fixed rotation in the world, is a rotation by psi about L after the alignment of L.
  const int a = about_one ? axes.one : axes.three;
  Quat<S> about_L{real::cos(half_psi), S(0), S(0), S(0)};
  (&about_L.x)[a] = real::sin(half_psi);
  Quat<S> step = alignment(a, L) * about_L * conjugate(alignment(a, L_new));
  if (step.w < S(0)) step = {-step.w, -step.x, -step.y, -step.z};
  turn.minus_one = {step.w - S(1), step.x, step.y, step.z};
  turn.dw_B = L_new - L;
}

template void exact_turn<float>(const Vec3<float>&, float, const Vec3<float>&, FreeTurn<float>&);
template void exact_turn<double>(const Vec3<double>&, double, const Vec3<double>&, FreeTurn<double>&);
template void exact_turn<long double>(const Vec3<long double>&, long double, const Vec3<long double>&,
                                      FreeTurn<long double>&);
template void exact_turn<Quad>(const Vec3<Quad>&, Quad, const Vec3<Quad>&, FreeTurn<Quad>&);

}  // namespace atwood
