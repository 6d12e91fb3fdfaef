// When two bodies on straight lines, each with constant spin, first touch.
#include <quadmath.h>

#include <algorithm>
#include <stdexcept>

#include "geometry/pieces.hpp"

namespace atwood::geometry {
namespace {

Vector widened(const Real3& v) { return {v[0], v[1], v[2]}; }

// q(t) = q0 exp(w_B t / 2): constant spin about an axis fixed in the body, and so in the world.
Place place_at(const Body& body, Real t_s) {
  const Vector w = widened(body.angular_velocity_body_rad_per_s);
  const Real rate = norm(w), angle = rate * t_s / 2;
  const Vector u = rate > 0 ? (std::sin(angle) / rate) * w : Vector{};
  const Real c = std::cos(angle);
  const auto& q = body.orientation_wxyz;
  const Vector v{q[1], q[2], q[3]};
  const Vector turned_v = c * v + Real(q[0]) * u + cross(v, u);
  return place_of(widened(body.position_m) + t_s * widened(body.velocity_m_per_s),
                  {Real(q[0]) * c - dot(v, u), turned_v[0], turned_v[1], turned_v[2]});
}

// How far the shape's points are from the body's origin at most; spin moves no point of a sphere's surface as a set.
Real lever(const Body& body) {
  if (std::holds_alternative<Sphere>(body.shape) || std::holds_alternative<Plane>(body.shape)) return 0;
  if (const auto* c = std::get_if<Cylinder>(&body.shape)) return std::hypot(Real(c->radius_m), Real(c->half_length_m));
  if (const auto* c = std::get_if<Capsule>(&body.shape)) return c->half_length_m;
  Real most = 0;
  for (const Piece& piece : pieces_of(body.shape, Place{}))
    for (const Vector& v : piece.vertices) most = std::max(most, norm(v));
  return most;
}

// Earliest t >= 0 with |r + v t| = sum of the radii, in quad:  v.v t^2 + 2 r.v t + r.r - s^2 = 0, r.v < 0.
std::optional<Wide> spheres_meet(const Body& a, const Body& b, Wide sum) {
  Wide rr = 0, rv = 0, vv = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Wide r = static_cast<Wide>(b.position_m[i]) - a.position_m[i];
    const Wide v = static_cast<Wide>(b.velocity_m_per_s[i]) - a.velocity_m_per_s[i];
    rr += r * r, rv += r * v, vv += v * v;
  }
  const Wide c = rr - sum * sum;
  if (c <= 0) return Wide(0);
  const Wide discriminant = rv * rv - vv * c;
  if (rv >= 0 || discriminant < 0) return std::nullopt;
  return c / (-rv + sqrtq(discriminant));  // no cancellation
}

std::optional<Wide> sphere_meets_plane(const Body& ball, const Plane& plane, Wide radius) {
  Wide height = -static_cast<Wide>(plane.offset_m), speed = 0, nn = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Wide n = plane.normal[i];
    height += n * ball.position_m[i], speed += n * ball.velocity_m_per_s[i], nn += n * n;
  }
  const Wide length = sqrtq(nn), gap = height / length - radius;
  if (gap <= 0) return Wide(0);
  if (speed >= 0) return std::nullopt;
  return -gap * length / speed;
}

FirstTouch at(const Body& a, const Body& b, Real t_s, Real bar_s) {
  const Separation found = separation(a.shape, place_at(a, t_s), b.shape, place_at(b, t_s));
  return {t_s, bar_s, found.normal, Real(0.5) * (found.on_a + found.on_b)};
}

// The direction n of the gap at t parts them until the gap is used up at the greatest speed along n that straight motion and
// spin allow: gap(t + h) >= gap(t) - h (n . (v_a - v_b) + |w_a| r_a + |w_b| r_b).
std::optional<FirstTouch> advance(const Body& a, const Body& b, Real t_end_s) {
  const Vector v = widened(a.velocity_m_per_s) - widened(b.velocity_m_per_s);
  const auto spin_of = [](const Body& body) { return norm(widened(body.angular_velocity_body_rad_per_s)) * lever(body); };
  const Real spin = spin_of(a) + spin_of(b);
  Real t_s = 0;
  constexpr int kMost = 20000;
  for (int i = 0; i < kMost; ++i) {
    const Separation found = separation(a.shape, place_at(a, t_s), b.shape, place_at(b, t_s));
    const Real speed = dot(found.normal, v) + spin;
    // Twice the bar is as near as its own round-off lets it come.
    if (found.gap_m <= 2 * found.bar_m) return at(a, b, t_s, speed > 0 ? 4 * found.bar_m / speed + 4 * kUnit * t_s : 0);
    if (!(speed > 0)) return std::nullopt;
    t_s += found.gap_m / speed;
    if (t_s > t_end_s) return std::nullopt;
  }
  return at(a, b, t_s, t_end_s - t_s);  // a graze: it may yet pass by
}

}  // namespace

std::optional<FirstTouch> first_touch(const Scene& scene, int body_a, int body_b, double t_end_s) {
  const Body &a = scene.bodies.at(static_cast<std::size_t>(body_a)), &b = scene.bodies.at(static_cast<std::size_t>(body_b));
  if (const std::string why = no_separation(a.shape, b.shape); !why.empty())
    throw std::invalid_argument("truth: no separation of " + why);
  const auto *ball_a = std::get_if<Sphere>(&a.shape), *ball_b = std::get_if<Sphere>(&b.shape);
  const auto *plane_a = std::get_if<Plane>(&a.shape), *plane_b = std::get_if<Plane>(&b.shape);
  std::optional<Wide> t;
  if (ball_a && ball_b) t = spheres_meet(a, b, static_cast<Wide>(ball_a->radius_m) + ball_b->radius_m);
  else if (ball_a && plane_b) t = sphere_meets_plane(a, *plane_b, ball_a->radius_m);
  else if (plane_a && ball_b) t = sphere_meets_plane(b, *plane_a, ball_b->radius_m);
  else return advance(a, b, t_end_s);
  if (!t || *t > t_end_s) return std::nullopt;
  return at(a, b, static_cast<Real>(*t), kUnit * static_cast<Real>(*t));
}

}  // namespace atwood::geometry
