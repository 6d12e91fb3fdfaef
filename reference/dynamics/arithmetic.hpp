// Arithmetic over double, long double and Wide that the reference needs: 3-vectors, 3x3 matrices, quaternions, square
// roots.
#pragma once

#include <quadmath.h>

#include <array>
#include <cmath>

#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::dynamics {

inline double sqrt(double x) { return std::sqrt(x); }
inline long double sqrt(long double x) { return std::sqrt(x); }
inline Wide sqrt(Wide x) { return sqrtq(x); }
inline double cos(double x) { return std::cos(x); }
inline long double cos(long double x) { return std::cos(x); }
inline Wide cos(Wide x) { return cosq(x); }
inline double sin(double x) { return std::sin(x); }
inline long double sin(long double x) { return std::sin(x); }
inline Wide sin(Wide x) { return sinq(x); }
inline double atan2(double y, double x) { return std::atan2(y, x); }
inline long double atan2(long double y, long double x) { return std::atan2(y, x); }
inline Wide atan2(Wide y, Wide x) { return atan2q(y, x); }
inline double magnitude(double x) { return std::fabs(x); }
inline long double magnitude(long double x) { return std::fabs(x); }
inline Wide magnitude(Wide x) { return x < 0 ? -x : x; }

inline double rsqrt(double x) { return 1 / std::sqrt(x); }
inline long double rsqrt(long double x) { return 1 / std::sqrt(x); }
// 1/sqrt(x) in quad from a double seed y: with e = 1 - x y^2 ~ 2^-52, 1/sqrt(x) = y (1 - e)^(-1/2)
//   = y (1 + e/2 + 3/8 e^2 + O(e^3 ~ 2^-156)).
// A third of the cost of a square root and a division.
inline Wide rsqrt(Wide x) {
  const double narrow = static_cast<double>(x);
  if (!(narrow > 1e-290 && narrow < 1e290)) return Wide(1) / sqrtq(x);
  const Wide y = 1 / std::sqrt(narrow);
  const Wide e = 1 - x * y * y;
  return y + y * e * (Wide(0.5) + Wide(0.375) * e);
}

template <class S> using Triple = std::array<S, 3>;

template <class S> Triple<S> read3(const S* y) { return {y[0], y[1], y[2]}; }
template <class S> Triple<S> widen(const Real3& v) { return {S(v[0]), S(v[1]), S(v[2])}; }
template <class S> Triple<S> operator+(const Triple<S>& a, const Triple<S>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class S> Triple<S> operator-(const Triple<S>& a, const Triple<S>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class S> Triple<S> operator*(const S& s, const Triple<S>& a) { return {s * a[0], s * a[1], s * a[2]}; }
template <class S> void operator+=(Triple<S>& a, const Triple<S>& b) {
  for (int i = 0; i < 3; ++i) a[i] += b[i];
}
template <class S> void operator-=(Triple<S>& a, const Triple<S>& b) {
  for (int i = 0; i < 3; ++i) a[i] -= b[i];
}
template <class S> S dot(const Triple<S>& a, const Triple<S>& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
template <class S> S norm(const Triple<S>& a) { return sqrt(dot(a, a)); }
template <class S> Triple<S> cross(const Triple<S>& a, const Triple<S>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// R(q) v = v + 2 u x (u x v + w v), q = (w, u) unit. The inverse turns the sign of u.
template <class S> Triple<S> rotate(const std::array<S, 4>& q, const Triple<S>& v) {
  const Triple<S> u{q[1], q[2], q[3]};
  return v + S(2) * cross(u, cross(u, v) + q[0] * v);
}
template <class S> Triple<S> rotate_back(const std::array<S, 4>& q, const Triple<S>& v) {
  return rotate<S>({q[0], -q[1], -q[2], -q[3]}, v);
}

template <class S> using Matrix = std::array<S, 9>;
template <class S> Triple<S> multiply(const Matrix<S>& m, const Triple<S>& v) {
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}

}  // namespace atwood::dynamics
