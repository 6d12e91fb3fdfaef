// The arithmetic of the closed forms over long double and quad: functions, vectors of three, quaternions (w first).
#pragma once

#include <quadmath.h>

#include <array>
#include <cmath>
#include <limits>

#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::closed_form {

using Narrow = long double;

inline Narrow root(Narrow x) { return std::sqrt(x); }
inline Wide root(Wide x) { return sqrtq(x); }
inline Narrow sine(Narrow x) { return std::sin(x); }
inline Wide sine(Wide x) { return sinq(x); }
inline Narrow cosine(Narrow x) { return std::cos(x); }
inline Wide cosine(Wide x) { return cosq(x); }
inline Narrow tangent(Narrow x) { return std::tan(x); }
inline Wide tangent(Wide x) { return tanq(x); }
inline Narrow arc_tangent(Narrow x) { return std::atan(x); }
inline Wide arc_tangent(Wide x) { return atanq(x); }
inline Narrow arc_tangent(Narrow y, Narrow x) { return std::atan2(y, x); }
inline Wide arc_tangent(Wide y, Wide x) { return atan2q(y, x); }
inline Narrow exponential(Narrow x) { return std::exp(x); }
inline Wide exponential(Wide x) { return expq(x); }
inline Narrow exponential_minus_1(Narrow x) { return std::expm1(x); }
inline Wide exponential_minus_1(Wide x) { return expm1q(x); }
inline Narrow log_of_1_plus(Narrow x) { return std::log1p(x); }
inline Wide log_of_1_plus(Wide x) { return log1pq(x); }
inline Narrow logarithm(Narrow x) { return std::log(x); }
inline Wide logarithm(Wide x) { return logq(x); }
inline Narrow hyperbolic_sine(Narrow x) { return std::sinh(x); }
inline Wide hyperbolic_sine(Wide x) { return sinhq(x); }
inline Narrow hyperbolic_cosine(Narrow x) { return std::cosh(x); }
inline Wide hyperbolic_cosine(Wide x) { return coshq(x); }
inline Narrow hyperbolic_tangent(Narrow x) { return std::tanh(x); }
inline Wide hyperbolic_tangent(Wide x) { return tanhq(x); }
inline Narrow floor_of(Narrow x) { return std::floor(x); }
inline Wide floor_of(Wide x) { return floorq(x); }
template <class S> S magnitude(S x) { return x < 0 ? -x : x; }
template <class S> S larger(S a, S b) { return a < b ? b : a; }
template <class S> bool is_finite(S x) { return x - x == 0; }

template <class S> constexpr int kDigits = std::numeric_limits<S>::digits;  // of the significand
template <> inline constexpr int kDigits<Wide> = 113;
template <class S> S unit_round_off() { return std::ldexp(1.0, -kDigits<S>); }
template <class S> S pi() { return 4 * arc_tangent(S(1)); }

template <class S> using Vec = std::array<S, 3>;
template <class S> using Quat = std::array<S, 4>;

template <class S> Vec<S> vec(const Real3& v) { return {S(v[0]), S(v[1]), S(v[2])}; }
template <class S> Vec<S> operator+(const Vec<S>& a, const Vec<S>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class S> Vec<S> operator-(const Vec<S>& a, const Vec<S>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class S> Vec<S> operator*(const S& s, const Vec<S>& a) { return {s * a[0], s * a[1], s * a[2]}; }
template <class S> S dot(const Vec<S>& a, const Vec<S>& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
template <class S> Vec<S> cross(const Vec<S>& a, const Vec<S>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class S> S norm(const Vec<S>& a) { return root(dot(a, a)); }
template <class S> bool is_zero(const Vec<S>& a) { return a[0] == 0 && a[1] == 0 && a[2] == 0; }

template <class S> Quat<S> operator*(const Quat<S>& a, const Quat<S>& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}
template <class S> Quat<S> conjugate(const Quat<S>& q) { return {q[0], -q[1], -q[2], -q[3]}; }
template <class S> Vec<S> rotate(const Quat<S>& q, const Vec<S>& v) {
  const Vec<S> u{q[1], q[2], q[3]};
  return v + S(2) * cross(u, cross(u, v) + q[0] * v);
}
// Turns by `angle` about the unit vector `axis`; continuous in the angle beyond 2 pi.
template <class S> Quat<S> turn(const Vec<S>& axis, S angle) {
  const S s = sine(angle / 2);
  return {cosine(angle / 2), s * axis[0], s * axis[1], s * axis[2]};
}
// The scene's quaternion is unit to the round-off of double; the problem is the direction it gives.
template <class S> Quat<S> quat(const Real4& given) {
  Quat<S> q{S(given[0]), S(given[1]), S(given[2]), S(given[3])};
  const S length = root(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (S& part : q) part /= length;
  return q;
}

}  // namespace atwood::closed_form
