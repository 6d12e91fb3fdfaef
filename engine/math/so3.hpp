// Rotations and their generators: exponential, logarithm, and the derivative of the exponential.
//
// A rotation vector s = theta n turns by theta [rad] about the unit axis n. Iserles, Munthe-Kaas, Norsett and Zanna,
// Acta Numerica 9 (2000) 215, appendix B; every coefficient is free of cancellation at small theta.
#pragma once

#include "math/quat.hpp"

namespace atwood {

// sum_k (-x)^k / (2k + first)!, which is (theta - sin theta) / theta^3 for x = theta^2, first = 3, and
// (cos theta - 1 + theta^2 / 2) / theta^4 for first = 4. Terms fall from the first on while x < first (first + 1).
template <class S> S alternating_series(S x, int first) {
  S term = S(1);
  for (int k = 2; k <= first; ++k) term /= S(k);
  S sum = term;
  for (int k = first + 1; real::abs(term) > real::epsilon<S>() * real::abs(sum) / S(4); k += 2) {
    term *= -x / (S(k) * S(k + 1));
    sum += term;
  }
  return sum;
}

// sin(x) / x
template <class S> S sinc(S x) { return x * x < real::epsilon<S>() ? S(1) - x * x / S(6) : real::sin(x) / x; }

// The unit quaternion that turns by s.
template <class S> Quat<S> so3_exp(const Vec3<S>& s) {
  const S half = norm(s) / S(2);
  S sine, cosine;
  real::sin_cos(half, sine, cosine);
  const S factor = (half * half < real::epsilon<S>() ? S(1) - half * half / S(6) : sine / half) / S(2);
  return {cosine, factor * s.x, factor * s.y, factor * s.z};
}

// The same minus one, accurate as an increment: cos - 1 = -sin^2 / (1 + cos).
template <class S> Quat<S> so3_exp_minus_one(const Vec3<S>& s) {
  const Quat<S> q = so3_exp(s);
  const S square = q.x * q.x + q.y * q.y + q.z * q.z;
  return {q.w < S(0) ? q.w - S(1) : -square / (S(1) + q.w), q.x, q.y, q.z};
}

// The shortest rotation vector of a unit quaternion, |s| <= pi; q and -q give the same.
template <class S> Vec3<S> so3_log(const Quat<S>& q) {
  const Vec3<S> u = (q.w < S(0) ? S(-1) : S(1)) * Vec3<S>{q.x, q.y, q.z};
  const S sine = norm(u), cosine = real::abs(q.w);
  if (sine == S(0)) return S(2) * u;
  return (S(2) * real::atan2(sine, cosine) / sine) * u;
}

// J x with J = sum_k [s]^k / (k + 1)!: exp(s)' exp(-s) = J s', the rate seen from the world for s in world axes. The
// right Jacobian, the rate seen from the body, is J of -s.
template <class S> Vec3<S> left_jacobian(const Vec3<S>& s, const Vec3<S>& x) {
  const S square = dot(s, s), half = sinc(real::sqrt(square) / S(2));
  const S third = square < S(4) ? alternating_series(square, 3)
                                : (S(1) - real::sin(real::sqrt(square)) / real::sqrt(square)) / square;
  const Vec3<S> sx = cross(s, x);
  return x + (half * half / S(2)) * sx + third * cross(s, sx);
}

// J^-1 x = x - s x x / 2 + (1 - theta/2 cot(theta/2)) / theta^2 s x (s x x), for theta < 2 pi. With c, d the two series
// above the last coefficient is (c - 2 d) / (2 (1 - cos theta) / theta^2).
template <class S> Vec3<S> inverse_left_jacobian(const Vec3<S>& s, const Vec3<S>& x) {
  const S square = dot(s, s), half = sinc(real::sqrt(square) / S(2));
  S last;
  if (square < S(4)) {
    last = (alternating_series(square, 3) - S(2) * alternating_series(square, 4)) / (half * half);
  } else {
    last = (S(1) - real::cos(real::sqrt(square) / S(2)) / half) / square;
  }
  const Vec3<S> sx = cross(s, x);
  return x - S(0.5) * sx + last * cross(s, sx);
}

}  // namespace atwood
