// Vectors, quaternions (w, x, y, z) and rotations in __float128, for starts of mechanisms that are exact to far below a
// double's last digit.
#pragma once

#include <quadmath.h>

#include <array>

namespace atwood::quad {

using Real = __float128;
using Vector = std::array<Real, 3>;
using Quaternion = std::array<Real, 4>;

inline Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector operator*(Real s, const Vector& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Real dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Real norm(const Vector& a) { return sqrtq(dot(a, a)); }
inline Vector wide(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }
inline std::array<double, 3> rounded(const Vector& a) {
  return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
}
// Of a vector that is not 0.
inline Vector unit(const Vector& a) { return (1 / norm(a)) * a; }

inline Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}
inline Quaternion conjugate(const Quaternion& q) { return {q[0], -q[1], -q[2], -q[3]}; }
// Of a quaternion that is not 0.
inline Quaternion normalised(const Quaternion& q) {
  const Real scale = 1 / sqrtq(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {scale * q[0], scale * q[1], scale * q[2], scale * q[3]};
}
inline Quaternion wide(const std::array<double, 4>& q) { return {q[0], q[1], q[2], q[3]}; }
inline std::array<double, 4> rounded(const Quaternion& q) {
  return {static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2]), static_cast<double>(q[3])};
}
// exp(axis angle) of a unit axis.
inline Quaternion turn(const Vector& axis, Real angle) {
  const Real s = sinq(angle / 2);
  return {cosq(angle / 2), s * axis[0], s * axis[1], s * axis[2]};
}
// exp(v): the turn by |v| about v.
inline Quaternion exponential(const Vector& v) {
  const Real angle = norm(v);
  return angle == 0 ? Quaternion{1, 0, 0, 0} : turn((1 / angle) * v, angle);
}
// R v and R^T v of a unit quaternion.
inline Vector rotate(const Quaternion& q, const Vector& v) {
  const Vector u{q[1], q[2], q[3]}, t = Real(2) * cross(u, v);
  return v + q[0] * t + cross(u, t);
}
inline Vector rotate_back(const Quaternion& q, const Vector& v) { return rotate(conjugate(q), v); }

// Two unit vectors that make a frame with a unit vector.
inline std::array<Vector, 2> orthogonal_pair(const Vector& axis) {
  std::size_t least = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (fabsq(axis[i]) < fabsq(axis[least])) least = i;
  Vector other{};
  other[least] = 1;
  const Vector first = unit(cross(axis, other));
  return {first, cross(axis, first)};
}

}  // namespace atwood::quad
