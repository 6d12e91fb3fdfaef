// Three-vectors, quaternions (w, x, y, z) and 3x3 matrices (row-major) of doubles, for the conversions of adapters.
#pragma once

#include <cmath>

#include "scene/scene.hpp"

namespace atwood::rivals {

inline Real3 operator+(const Real3& a, const Real3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Real3 operator-(const Real3& a, const Real3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Real3 operator*(double s, const Real3& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline void add(Real3& a, const Real3& b) {
  for (int i = 0; i < 3; ++i) a[i] += b[i];
}
inline double dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(const Real3& a) { return std::sqrt(dot(a, a)); }
inline Real3 cross(const Real3& a, const Real3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Rotation matrix of a unit quaternion: v_W = R v_B.
inline Real33 matrix_of(const Real4& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}
inline Real3 times(const Real33& m, const Real3& v) {
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}
inline Real3 transposed_times(const Real33& m, const Real3& v) {
  return {m[0] * v[0] + m[3] * v[1] + m[6] * v[2], m[1] * v[0] + m[4] * v[1] + m[7] * v[2],
          m[2] * v[0] + m[5] * v[1] + m[8] * v[2]};
}
// Body axes to world axes and back.
inline Real3 to_world(const Real4& q_WB, const Real3& v_B) { return times(matrix_of(q_WB), v_B); }
inline Real3 to_body(const Real4& q_WB, const Real3& v_W) { return transposed_times(matrix_of(q_WB), v_W); }

inline Real4 product(const Real4& a, const Real4& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}
inline Real4 conjugate(const Real4& q) { return {q[0], -q[1], -q[2], -q[3]}; }

// Unit quaternion of a rotation matrix (Shepperd 1978: the largest of the four squares is the divisor).
Real4 quaternion_of(const Real33& m);

}  // namespace atwood::rivals
