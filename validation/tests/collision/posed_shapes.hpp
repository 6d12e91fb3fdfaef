// Random shapes and poses for the tests of geometry.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "collision/contacts.hpp"
#include "collision/hull.hpp"

namespace atwood::testing {

using Random = std::mt19937_64;

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline Real3 gauss3(Random& random) {
  std::normal_distribution<double> n;
  return {n(random), n(random), n(random)};
}
inline Quat<double> any_turn(Random& random) {
  std::normal_distribution<double> n;
  return normalised(Quat<double>{n(random), n(random), n(random), n(random)});
}

template <class S> Transform<S> placed_at(const Vec3<double>& p_W, const Quat<double>& q_WB = {}) {
  const Quat<S> q = normalised(Quat<S>{S(q_WB.w), S(q_WB.x), S(q_WB.y), S(q_WB.z)});
  return {{S(p_W.x), S(p_W.y), S(p_W.z)},
          {rotate(q, Vec3<S>{S(1), S(0), S(0)}), rotate(q, Vec3<S>{S(0), S(1), S(0)}),
           rotate(q, Vec3<S>{S(0), S(0), S(1)})}};
}

template <class S> bool finite(const Vec3<S>& v) {
  return real::is_finite(v.x) && real::is_finite(v.y) && real::is_finite(v.z);
}

// Points on an ellipsoid.
inline std::vector<Real3> boulder(Random& random, int points, const Real3& radii) {
  std::vector<Real3> out;
  for (int i = 0; i < points; ++i) {
    const Real3 d = gauss3(random);
    const double size = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    out.push_back({radii[0] * d[0] / size, radii[1] * d[1] / size, radii[2] * d[2] / size});
  }
  return out;
}

inline std::vector<Real3> box_corners(const Real3& h) {
  std::vector<Real3> out;
  for (int i = 0; i < 8; ++i) out.push_back({i & 1 ? h[0] : -h[0], i & 2 ? h[1] : -h[1], i & 4 ? h[2] : -h[2]});
  return out;
}

constexpr ShapeKind kConvexKinds[] = {ShapeKind::sphere,  ShapeKind::rectangle, ShapeKind::box,
                                      ShapeKind::capsule, ShapeKind::cylinder,  ShapeKind::convex};

// A shape as data, so that it can be made in any scalar. Sizes within [0.1, 1], each times spread^u for u in [-1, 1].
inline Shape random_shape(ShapeKind kind, Random& random, double spread = 1) {
  const auto size = [&] { return uniform(random, 0.1, 1) * std::pow(spread, uniform(random, -1, 1)); };
  const double x = size(), y = size(), z = size();
  switch (kind) {
    case ShapeKind::sphere: return Sphere{x};
    case ShapeKind::rectangle: return Rectangle{{x, y}};
    case ShapeKind::box: return Box{{x, y, z}};
    case ShapeKind::capsule: return Capsule{x, y};
    case ShapeKind::cylinder: return Cylinder{x, y};
    default: return Convex{boulder(random, 20, {x, y, z})};
  }
}

}  // namespace atwood::testing
