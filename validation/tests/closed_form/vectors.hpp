// Vectors of the integrations that the closed forms are compared with.
#pragma once

#include <array>
#include <cmath>

namespace atwood::testing {

using Vec3 = std::array<double, 3>;
inline Vec3 plus(const Vec3& a, double s, const Vec3& b) { return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]}; }
inline Vec3 times(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double along(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(const Vec3& a) { return std::sqrt(along(a, a)); }
template <class V> Vec3 narrow(const V& v) { return {double(v[0]), double(v[1]), double(v[2])}; }

}  // namespace atwood::testing
