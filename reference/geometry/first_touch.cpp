// First contact of two bodies in uniform motion, each with constant angular velocity: conservative advancement.
#include <quadmath.h>

#include <algorithm>
#include <stdexcept>

#include "geometry/convex_parts.hpp"

namespace atwood::geometry {
namespace {

// q(t) = q0 exp(w_B t / 2): constant spin about an axis fixed in the body, and so in the world.
Pose pose_at(const Body& body, Real t_s) {
  const Vector w = widened(body.angular_velocity_body_rad_per_s);
  const Real rate = norm(w), angle = rate * t_s / 2;
  const Vector u = rate > 0 ? (std::sin(angle) / rate) * w : Vector{};
  const Real c = std::cos(angle);
  const auto& q = body.orientation_wxyz;
  const Vector v{q[1], q[2], q[3]};
  const Vector turned_v = c * v + Real(q[0]) * u + cross(v, u);
  return pose_of(widened(body.position_m) + t_s * widened(body.velocity_m_per_s),
                 {Real(q[0]) * c - dot(v, u), turned_v[0], turned_v[1], turned_v[2]});
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
  const Separation found = separation(a.shape, pose_at(a, t_s), b.shape, pose_at(b, t_s));
  return {t_s, bar_s, found.normal, Real(0.5) * (found.on_a + found.on_b)};
}

// ---- advancing ------------------------------------------------------------------------------------------------------
// A part of a body under rotation: points relative to the body's origin, in world axes; a cylinder by its support
// function. The rounding radius of spheres and capsules does not rotate.
struct Arm {
  std::vector<Vector> points;
  const Cylinder* drum = nullptr;
  Vector axis{};

  Real support(const Vector& n) const {
    if (drum != nullptr) {
      const Real along = dot(n, axis);
      return static_cast<Real>(drum->half_length_m) * std::fabs(along) +
             static_cast<Real>(drum->radius_m) * norm(n - along * axis);
    }
    Real most = -std::numeric_limits<Real>::infinity();
    for (const Vector& r : points) most = std::max(most, dot(n, r));
    return most;
  }
  // Support function of the circle that the point describes about the axis along w: (u . r) u + |u x r| orthogonal to
  // u.
  Real support_of_turn(const Vector& n, const Vector& w) const {
    const Real rate = norm(w);
    if (!(rate > 0)) return support(n);
    const Vector u = (1 / rate) * w;
    const Real along = dot(n, u), across = norm(cross(n, u));
    if (drum != nullptr) {
      const Real up = dot(u, axis), out = norm(cross(u, axis));
      const Real h = drum->half_length_m, r = drum->radius_m, least = std::max<Real>(0, h * std::fabs(up) - r * out);
      return std::fabs(along) * support((along < 0 ? -1 : 1) * u) +
             across * std::sqrt(std::max<Real>(0, h * h + r * r - least * least));
    }
    Real most = -std::numeric_limits<Real>::infinity();
    for (const Vector& r : points) most = std::max(most, along * dot(u, r) + across * norm(cross(u, r)));
    return most;
  }
  Real length() const {
    if (drum != nullptr) return std::hypot(Real(drum->radius_m), Real(drum->half_length_m));
    Real most = 0;
    for (const Vector& r : points) most = std::max(most, norm(r));
    return most;
  }
};

// The polyhedron, if it is one
struct Part {
  Arm arm;
  std::vector<ConvexPart> polyhedron;
};

std::vector<Part> parts_of(const Shape& shape, const Pose& pose) {
  std::vector<Part> parts;
  if (const auto* drum = std::get_if<Cylinder>(&shape)) return {{{{}, drum, pose.axis_W[2]}, {}}};
  for (const ConvexPart& convex : convex_parts_of(shape, pose)) {
    Part part{{}, {convex}};
    for (const Vector& v : convex.vertices) part.arm.points.push_back(v - pose.p_W);
    parts.push_back(std::move(part));
  }
  if (parts.empty()) parts.push_back({{{Vector{}}}, {}});  // a plane
  return parts;
}

struct Spin {
  Vector w;
  const Arm& arm;
};

// The time after which a gap that closes at this speed is floor_m; at most `most`.
Real time_to_close(Real gap, Real floor_m, Real closing, Real most) {
  if (!(gap > floor_m)) return 0;
  return most * closing < gap - floor_m ? most : (gap - floor_m) / closing;
}

// A lower bound of the time during which two parts with a gap along n stay separated along n; `most` when they are
// separated until then. The coordinate along n of a point r of a rotating body after h is at most
// n.r + h n.(w x r) + |w| |n x w| |r| h^2 / 2 (Taylor's formula with a bound of the remainder).
Real stay(Real gap, Real floor_m, const Vector& n, const Vector& v, const Spin& a, const Spin& b, Real most) {
  const Vector turn_a = cross(n, a.w), turn_b = cross(n, b.w);
  const Real bend = norm(a.w) * norm(turn_a) * a.arm.length() + norm(b.w) * norm(turn_b) * b.arm.length();
  const Real now = a.arm.support(n) + b.arm.support(-1 * n);
  const auto apart = [&](Real h) {
    return gap - h * dot(n, v) - (a.arm.support(n + h * turn_a) + b.arm.support(-1 * n - h * turn_b) - now) -
           bend * h * h / 2;
  };
  if (apart(most) > 0) return most;  // the gap is concave in time, therefore positive before
  // With the supports of whole revolutions a part of the gap may remain, which then closes by translation only.
  const Real left = gap - (a.arm.support_of_turn(n, a.w) + b.arm.support_of_turn(-1 * n, b.w) - now);
  const Real in_flight = time_to_close(left, floor_m, dot(n, v), most);
  if (in_flight >= most) return most;
  Real low = 0, high = most;
  const Real fastest = std::fabs(dot(n, v)) + norm(turn_a) * a.arm.length() + norm(turn_b) * b.arm.length();
  if (bend == 0 && dot(n, v) > 0) return std::min(most, gap / dot(n, v));
  if (fastest > 0) low = std::min(most, gap / (fastest + std::sqrt(bend * gap)));
  while (2 * low < high && apart(2 * low) > 0) low *= 2;
  high = std::min(high, 2 * low);
  for (int i = 0; i < 6; ++i) {
    const Real middle = (low + high) / 2;
    (apart(middle) > 0 ? low : high) = middle;
  }
  return std::max(low, in_flight);
}

// The same along the face normals of both, which may separate them for longer than the direction between their closest
// points.
Real stay_along_faces(const Part& p, const Part& q, const Vector& from_p_to_q, const Vector& v, const Vector& w_p,
                      const Vector& w_q, Real floor_m, Real most) {
  Real longest = 0;
  if (p.polyhedron.empty() || q.polyhedron.empty()) return longest;
  const Real skins = p.polyhedron.front().radius_m + q.polyhedron.front().radius_m;
  for (const Part* of : {&p, &q})
    for (const auto& face : of->polyhedron.front().faces)
      for (const Real side : {-1.0L, 1.0L}) {
        const Vector n = side * face.normal;
        const Real left =
            dot(n, from_p_to_q) - p.arm.support_of_turn(n, w_p) - q.arm.support_of_turn(-1 * n, w_q) - skins;
        longest = std::max(longest, time_to_close(left, floor_m, dot(n, v), most));
      }
  return longest;
}

struct GapBounds {
  bool touching = false;
  Real speed = 0, floor_m = 0, stay_s = 0;
};

// All pairs of parts at one time.
GapBounds gap_bounds(const Body& a, const Body& b, Real t_s, Real most_s) {
  const auto spin_of = [](const Body& body) {
    const Pose pose = pose_at(body, 0);
    const bool still = std::holds_alternative<Sphere>(body.shape) || std::holds_alternative<Plane>(body.shape);
    return still ? Vector{} : to_world(pose, widened(body.angular_velocity_body_rad_per_s));
  };
  const Vector v = widened(a.velocity_m_per_s) - widened(b.velocity_m_per_s), w_a = spin_of(a), w_b = spin_of(b);
  const Pose pose_a = pose_at(a, t_s), pose_b = pose_at(b, t_s);
  const auto of_a = parts_of(a.shape, pose_a), of_b = parts_of(b.shape, pose_b);
  const Real extent = norm(pose_a.p_W) + norm(pose_b.p_W);
  GapBounds found{false, 0, 0, most_s};
  for (const Part& p : of_a)
    for (const Part& q : of_b) {
      const bool polyhedra = !p.polyhedron.empty() && !q.polyhedron.empty();
      const Separation s = polyhedra ? separation(p.polyhedron.front(), q.polyhedron.front())
                                     : separation(a.shape, pose_a, b.shape, pose_b);
      const Real arms = norm(w_a) * p.arm.length() + norm(w_b) * q.arm.length();
      // A gap of twice its round-off counts as a contact.
      const Real floor_m = 64 * kUnit * (extent + p.arm.length() + q.arm.length());
      if (s.gap_m <= floor_m) {
        const Real speed = dot(s.normal, v) + arms;
        if (!found.touching || speed > found.speed) found = {true, speed, std::max(floor_m, 2 * s.bar_m), 0};
      } else if (!found.touching) {
        Real stays = stay(s.gap_m, floor_m, s.normal, v, {w_a, p.arm}, {w_b, q.arm}, found.stay_s);
        if (stays < found.stay_s)
          stays = std::max(stays, stay_along_faces(p, q, pose_b.p_W - pose_a.p_W, v, w_a, w_b, floor_m, found.stay_s));
        found.stay_s = std::min(found.stay_s, stays);
      }
    }
  return found;
}

std::optional<FirstTouch> advance(const Body& a, const Body& b, Real t_end_s, Real given_m) {
  // Inside of a closed mesh there is an overlap that no pair of parts has; a gap within the rounding of the scene's
  // decimals is a contact.
  if (separation(a.shape, pose_at(a, 0), b.shape, pose_at(b, 0)).gap_m <= given_m) return at(a, b, 0, 0);
  Real t_s = 0;
  constexpr int max_advances = 20000;
  for (int i = 0; i < max_advances; ++i) {
    const GapBounds now = gap_bounds(a, b, t_s, t_end_s - t_s);
    if (now.touching) return at(a, b, t_s, now.speed > 0 ? 2 * now.floor_m / now.speed + 4 * kUnit * t_s : 0);
    if (t_s + now.stay_s >= t_end_s) {
      const bool touches = separation(a.shape, pose_at(a, t_end_s), b.shape, pose_at(b, t_end_s)).gap_m <= given_m;
      return touches ? std::optional(at(a, b, t_end_s, kUnit * t_end_s)) : std::nullopt;
    }
    t_s += now.stay_s;
  }
  FirstTouch undecided = at(a, b, t_s, t_end_s - t_s);  // a contact is not certain
  undecided.decided = false;
  return undecided;
}

}  // namespace

std::optional<FirstTouch> first_touch(const Scene& scene, int body_a, int body_b, double t_end_s) {
  const Body &a = scene.bodies.at(static_cast<std::size_t>(body_a)),
             &b = scene.bodies.at(static_cast<std::size_t>(body_b));
  if (const std::string why = no_separation(a.shape, b.shape); !why.empty())
    throw std::invalid_argument("truth: no separation of " + why);
  const auto *ball_a = std::get_if<Sphere>(&a.shape), *ball_b = std::get_if<Sphere>(&b.shape);
  const auto *plane_a = std::get_if<Plane>(&a.shape), *plane_b = std::get_if<Plane>(&b.shape);
  std::optional<Wide> t;
  const Real given_m = given_round_off(scene, body_a, body_b);
  if (ball_a && ball_b) t = spheres_meet(a, b, static_cast<Wide>(ball_a->radius_m) + ball_b->radius_m);
  else if (ball_a && plane_b) t = sphere_meets_plane(a, *plane_b, ball_a->radius_m);
  else if (plane_a && ball_b) t = sphere_meets_plane(b, *plane_a, ball_b->radius_m);
  else return advance(a, b, t_end_s, given_m);
  const auto touches_at = [&](Real t_s) {
    return separation(a.shape, pose_at(a, t_s), b.shape, pose_at(b, t_s)).gap_m <= given_m;
  };
  if (touches_at(0)) return at(a, b, 0, 0);
  if (!t || *t > t_end_s) return touches_at(t_end_s) ? std::optional(at(a, b, t_end_s, kUnit * t_end_s)) : std::nullopt;
  return at(a, b, static_cast<Real>(*t), kUnit * static_cast<Real>(*t));
}

}  // namespace atwood::geometry
