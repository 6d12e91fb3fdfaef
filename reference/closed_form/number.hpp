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

inline Narrow sqrt(Narrow x) { return std::sqrt(x); }
inline Wide sqrt(Wide x) { return sqrtq(x); }
inline Narrow sin(Narrow x) { return std::sin(x); }
inline Wide sin(Wide x) { return sinq(x); }
inline Narrow cos(Narrow x) { return std::cos(x); }
inline Wide cos(Wide x) { return cosq(x); }
inline Narrow tan(Narrow x) { return std::tan(x); }
inline Wide tan(Wide x) { return tanq(x); }
inline Narrow atan(Narrow x) { return std::atan(x); }
inline Wide atan(Wide x) { return atanq(x); }
inline Narrow atan2(Narrow y, Narrow x) { return std::atan2(y, x); }
inline Wide atan2(Wide y, Wide x) { return atan2q(y, x); }
inline Narrow exp(Narrow x) { return std::exp(x); }
inline Wide exp(Wide x) { return expq(x); }
inline Narrow expm1(Narrow x) { return std::expm1(x); }
inline Wide expm1(Wide x) { return expm1q(x); }
inline Narrow log1p(Narrow x) { return std::log1p(x); }
inline Wide log1p(Wide x) { return log1pq(x); }
inline Narrow log(Narrow x) { return std::log(x); }
inline Wide log(Wide x) { return logq(x); }
inline Narrow sinh(Narrow x) { return std::sinh(x); }
inline Wide sinh(Wide x) { return sinhq(x); }
inline Narrow cosh(Narrow x) { return std::cosh(x); }
inline Wide cosh(Wide x) { return coshq(x); }
inline Narrow tanh(Narrow x) { return std::tanh(x); }
inline Wide tanh(Wide x) { return tanhq(x); }
inline Narrow floor(Narrow x) { return std::floor(x); }
inline Wide floor(Wide x) { return floorq(x); }
template <class S> S magnitude(S x) { return x < 0 ? -x : x; }
template <class S> S larger(S a, S b) { return a < b ? b : a; }
template <class S> bool is_finite(S x) { return x - x == 0; }

template <class S> constexpr int kDigits = std::numeric_limits<S>::digits;  // of the significand
template <> inline constexpr int kDigits<Wide> = 113;
template <class S> S unit_round_off() { return std::ldexp(1.0, -kDigits<S>); }
template <class S> S pi() { return 4 * atan(S(1)); }

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
template <class S> S norm(const Vec<S>& a) { return sqrt(dot(a, a)); }
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
// The rotation by `angle` about the unit vector `axis`; continuous in the angle beyond 2 pi.
template <class S> Quat<S> turn(const Vec<S>& axis, S angle) {
  const S s = sin(angle / 2);
  return {cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]};
}
// The scene's quaternion is of unit length to the round-off of double; it is normalised in S.
template <class S> Quat<S> quat(const Real4& given) {
  Quat<S> q{S(given[0]), S(given[1]), S(given[2]), S(given[3])};
  const S length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (S& part : q) part /= length;
  return q;
}

}  // namespace atwood::closed_form
