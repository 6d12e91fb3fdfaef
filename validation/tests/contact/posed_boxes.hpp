// Boxes in any pose, and where two of them meet by all 15 separating axes: worked out apart from the engine.
#pragma once

#include <cmath>

#include "math/vec3.hpp"
#include "recorded.hpp"

namespace atwood::posed_boxes {

using Vector = Vec3<long double>;

// The rotation by `angle` about `axis`, and the product of two rotations.
inline Real4 about(const Real3& axis, double angle) {
  const double s = std::sin(angle / 2) / std::hypot(axis[0], axis[1], axis[2]);
  return {std::cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]};
}
inline Real4 times(const Real4& p, const Real4& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

// Half the short and the long sides of the bars whose edges meet.
inline constexpr double kHalf = 0.1, kLong = 0.5;

// Two bars in empty space, edge over edge: the lower one's along x, the upper one's along y, which comes down. The
// edges meet where x = `x`, y = `y` from the middles of the bars.
inline Scene crossed_bars(double e, double friction, double x, double y, double speed = 1, double height = 0.2) {
  Scene scene = recorded::world({0, 0, 0}, e, friction);
  Body low = recorded::box("low", 2, {kLong, kHalf, kHalf}, {-x, 0, 0}),
       high = recorded::box("high", 1, {kHalf, kLong, kHalf}, {});
  high.position_m = {0, y, 2 * kHalf * std::sqrt(2.) + height};
  high.velocity_m_per_s = {0, 0, -speed};
  low.orientation_wxyz = about({1, 0, 0}, M_PI / 4);
  high.orientation_wxyz = about({0, 1, 0}, M_PI / 4);
  scene.bodies = {low, high};
  return scene;
}

struct Placed {
  Vector p, axis[3], half;
};
struct Meeting {
  long double gap = -1e9L;
  Vector n, x;  // from b to a
  bool edges = false;
};

inline Vector vec(const Real3& v) { return {v[0], v[1], v[2]}; }
inline Vector wide(const std::array<Wide, 3>& v) {
  return {static_cast<long double>(v[0]), static_cast<long double>(v[1]), static_cast<long double>(v[2])};
}
inline Vector rotated(const Vector& v, const Vector& w, long double t) {  // Rodrigues
  const long double angle = norm(w) * t;
  if (angle == 0) return v;
  const Vector k = (1 / norm(w)) * w;
  return std::cos(angle) * v + std::sin(angle) * cross(k, v) + ((1 - std::cos(angle)) * dot(k, v)) * k;
}
inline Vector body_axis(const Body& body, int k) {
  const auto& q = body.orientation_wxyz;
  const Vector u{q[1], q[2], q[3]}, e{k == 0 ? 1.L : 0.L, k == 1 ? 1.L : 0.L, k == 2 ? 1.L : 0.L};
  const long double w = q[0], size = w * w + dot(u, u);
  const Vector turned = (w * w - dot(u, u)) * e + (2 * dot(u, e)) * u + (2 * w) * cross(u, e);
  return (1 / size) * turned;
}
inline Vector spin_W(const Body& body) {
  const auto& w = body.angular_velocity_body_rad_per_s;
  return w[0] * body_axis(body, 0) + w[1] * body_axis(body, 1) + w[2] * body_axis(body, 2);
}
// Of a body with equal moments of inertia, free.
inline Placed place_at(const Body& body, long double t) {
  Placed at;
  at.p = vec(body.position_m) + t * vec(body.velocity_m_per_s);
  at.half = vec(std::get<Box>(body.shape).half_extents_m);
  for (int k = 0; k < 3; ++k) at.axis[k] = rotated(body_axis(body, k), spin_W(body), t);
  return at;
}
inline long double half_of(const Placed& a, int k) { return k == 0 ? a.half.x : k == 1 ? a.half.y : a.half.z; }
inline long double width(const Placed& a, const Vector& n) {
  return half_of(a, 0) * std::abs(dot(n, a.axis[0])) + half_of(a, 1) * std::abs(dot(n, a.axis[1])) +
         half_of(a, 2) * std::abs(dot(n, a.axis[2]));
}
// The middle of what lies outermost along n.
inline Vector outermost(const Placed& a, const Vector& n) {
  Vector x = a.p;
  for (int k = 0; k < 3; ++k) {
    const long double along = dot(n, a.axis[k]);
    if (std::abs(along) > 1e-12L) x += (along > 0 ? half_of(a, k) : -half_of(a, k)) * a.axis[k];
  }
  return x;
}
// Apart if and only if the gap along one of the 15 axes is positive; the largest of them.
inline Meeting meet(const Placed& a, const Placed& b) {
  Meeting best;
  const auto take = [&](Vector n, int i, int j) {
    if (norm(n) < 1e-6L) return;
    n = (1 / norm(n)) * n;
    if (dot(n, a.p - b.p) < 0) n = -n;
    const long double gap = dot(n, a.p - b.p) - width(a, n) - width(b, n);
    if (gap <= best.gap + (i >= 0 ? 1e-15L : 0)) return;
    best.gap = gap;
    best.n = n;
    best.edges = i >= 0;
    if (i < 0) return;
    const Vector from = outermost(a, -n), to = outermost(b, n);  // middles of edges
    best.x = from + (dot(to - from, cross(b.axis[j], n)) / dot(n, cross(a.axis[i], b.axis[j]))) * a.axis[i];
  };
  for (int i = 0; i < 3; ++i) take(a.axis[i], -1, -1), take(b.axis[i], -1, -1);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) take(cross(a.axis[i], b.axis[j]), i, j);
  return best;
}

}  // namespace atwood::posed_boxes
