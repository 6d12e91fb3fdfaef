// The arithmetic of the checkers: 60 decimal digits, which nothing in reference/ uses.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <string>
#include <vector>

#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::fuzz {

using Long = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<60>, boost::multiprecision::et_off>;
using Long3 = std::array<Long, 3>;
using Long4 = std::array<Long, 4>;

// Exact: three doubles represent the 113 bits of a quad.
inline Long widened(Wide x) {
  Long sum = 0;
  for (int k = 0; k < 4; ++k) {
    const double part = static_cast<double>(x);
    if (!(part - part == 0)) return part;  // infinite or not a number
    sum += part;
    x -= part;
  }
  return sum;
}

inline Long3 widened(const Real3& v) { return {v[0], v[1], v[2]}; }
inline Long3 operator+(const Long3& a, const Long3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Long3 operator-(const Long3& a, const Long3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Long3 operator*(const Long& s, const Long3& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Long dot(const Long3& a, const Long3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Long3 cross(const Long3& a, const Long3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// R(q) v of a unit quaternion (w, x, y, z).
inline Long3 turned(const Long4& q, const Long3& v) {
  const Long3 u{q[1], q[2], q[3]};
  const Long3 t = Long(2) * cross(u, v);
  return v + q[0] * t + cross(u, t);
}
inline Long3 turned_back(const Long4& q, const Long3& v) { return turned({q[0], -q[1], -q[2], -q[3]}, v); }

// As BodySample
struct LongBody {
  Long3 p{};
  Long4 q{1, 0, 0, 0};
  Long3 v{}, w{};
};

// The result of a checker: values[k][i] of body i at t_end_s k / samples, and their half-width `own`.
struct Checked {
  std::string refused;  // not empty: the checker does not cover the scene, or did not converge
  std::vector<std::vector<LongBody>> values, own;
};

}  // namespace atwood::fuzz
