// The signed separation of two convex parts.
//
//   s(n) = min over b of n . b - max over a of n . a  is at most the true separation for every unit n. For overlapping
//   parts the largest s(n), with n normal to a face of either or to an edge of each, is minus the depth of least
//   penetration; these n are the face normals of their Minkowski difference. If some s(n) is positive, the parts are
//   separated, and the separation is the distance of two of their features.
#include <algorithm>

#include "geometry/convex_parts.hpp"

namespace atwood::geometry {
namespace {

struct Range {
  Real low, high;
};
Range range(const ConvexPart& part, const Vector& n) {
  Range r{dot(n, part.vertices.front()), 0};
  r.high = r.low;
  for (const Vector& v : part.vertices) {
    const Real x = dot(n, v);
    r.low = std::min(r.low, x);
    r.high = std::max(r.high, x);
  }
  return r;
}

Real extent(const ConvexPart& part) {
  Real most = part.radius_m;
  for (const Vector& v : part.vertices)
    for (const Real x : v) most = std::max(most, std::fabs(x));
  return most;
}

// ---- axes ---------------------------------------------------------------------------------------------------------
// sharpness: sine of the edges' angle; the round-off of their cross product is divided by it
struct Axis {
  Vector normal;
  Real s;
  Real sharpness;
};

class Axes {
 public:
  Axes(const ConvexPart& a, const ConvexPart& b) : a_(a), b_(b) {
    for (const auto& face : a.faces) add(face.normal, face.sharpness);
    for (const auto& face : b.faces) add(face.normal, face.sharpness);
    const auto edges_a = directions(a), edges_b = directions(b);
    for (const Vector& e : edges_a)
      for (const Vector& f : edges_b) add_cross(e, f);
    flat(a, edges_a, edges_b);
    flat(b, edges_b, edges_a);
  }

  // The least penetration, and the difference to the next direction.
  const Axis& best(Real& margin) const {
    const auto top =
        std::max_element(found_.begin(), found_.end(), [](const Axis& x, const Axis& y) { return x.s < y.s; });
    margin = std::numeric_limits<Real>::infinity();
    for (const Axis& other : found_)
      if (norm(other.normal - top->normal) > 1e-7L) margin = std::min(margin, top->s - other.s);
    return *top;
  }
  bool empty() const { return found_.empty(); }

 private:
  static std::vector<Vector> directions(const ConvexPart& part) {
    std::vector<Vector> all;
    for (const auto& [from, to] : part.edges) {
      const Vector e = part.vertices[static_cast<std::size_t>(to)] - part.vertices[static_cast<std::size_t>(from)];
      const Real length = norm(e);
      if (!(length > 0)) continue;
      const Vector unit = (1 / length) * e;
      const auto same = [&](const Vector& other) { return norm(cross(unit, other)) < 4 * kUnit; };
      if (std::none_of(all.begin(), all.end(), same)) all.push_back(unit);
    }
    return all;
  }
  void add(const Vector& n, Real sharpness) {
    const Range a = range(a_, n), b = range(b_, n);
    found_.push_back({n, b.low - a.high, sharpness});
    found_.push_back({-1 * n, a.low - b.high, sharpness});
  }
  void add_cross(const Vector& e, const Vector& f) {
    const Vector n = cross(e, f);
    const Real length = norm(n);
    if (length > 64 * kUnit) add((1 / length) * n, length);
  }
  // For a polygon also the normals of its sides in its plane, and those of the other's edges: they separate coplanar
  // parts.
  void flat(const ConvexPart& part, const std::vector<Vector>& own, const std::vector<Vector>& others) {
    if (part.dimension != 2) return;
    for (const Vector& e : own) add_cross(part.faces.front().normal, e);
    for (const Vector& e : others) add_cross(part.faces.front().normal, e);
  }

  const ConvexPart &a_, &b_;
  std::vector<Axis> found_;
};

// ---- closest features ---------------------------------------------------------------------------------------------
// Two points, and the unit normal of their features, of either sign; zero: only the direction between the points is
// known.
struct Candidate {
  Real distance;
  Vector on_a, on_b, normal;
  Real sharpness;
};

// The closest points, and all that are as close within slack_m. A displacement e along a feature changes a distance d
// by e^2 / 2 d only, so that round-off of the distances does not determine the feature and its direction.
struct Closest {
  Real slack_m = 0, least_m = std::numeric_limits<Real>::infinity();
  std::vector<Candidate> tied{};

  void offer(const Vector& p, const Vector& q, const Vector& n, Real sharp = 1) {
    const Real d = norm(q - p);
    if (d > least_m + slack_m) return;
    least_m = std::min(least_m, d);
    tied.push_back({d, p, q, n, sharp});
  }
  const Candidate& least() const {
    return *std::min_element(tied.begin(), tied.end(),
                             [](const auto& x, const auto& y) { return x.distance < y.distance; });
  }
};

bool within(const ConvexPart& part, const ConvexPart::Face& face, const Vector& p) {
  const std::size_t n = face.corners.size();
  int inside = 0, outside = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector& from = part.vertices[static_cast<std::size_t>(face.corners[i])];
    const Vector& to = part.vertices[static_cast<std::size_t>(face.corners[(i + 1) % n])];
    const Real side = dot(cross(to - from, p - from), face.normal);
    (side >= 0 ? inside : outside) += 1;
  }
  return inside == 0 || outside == 0;
}

void vertices_to_faces(const ConvexPart& a, const ConvexPart& b, bool swapped, Closest& closest) {
  for (const Vector& v : a.vertices)
    for (const auto& face : b.faces) {
      const Real height = dot(face.normal, v - b.vertices[static_cast<std::size_t>(face.corners[0])]);
      if (std::fabs(height) > closest.least_m + closest.slack_m) continue;
      const Vector foot = v - height * face.normal;
      if (!within(b, face, foot)) continue;
      if (swapped) closest.offer(foot, v, face.normal, face.sharpness);
      else closest.offer(v, foot, face.normal, face.sharpness);
    }
}

struct Segment {
  Vector from, along;
};
std::vector<Segment> segments(const ConvexPart& part) {
  std::vector<Segment> all;
  for (const auto& [from, to] : part.edges) {
    const Vector& p = part.vertices[static_cast<std::size_t>(from)];
    all.push_back({p, part.vertices[static_cast<std::size_t>(to)] - p});
  }
  if (all.empty()) all.push_back({part.vertices.front(), {}});  // a point
  return all;
}

Real clamped(Real x) { return std::min<Real>(std::max<Real>(x, 0), 1); }

// Each end against the other segment, and the two lines if both closest points are inside of the segments.
void segment_to_segment(const Segment& p, const Segment& q, Closest& closest) {
  const Real pp = dot(p.along, p.along), qq = dot(q.along, q.along);
  const auto on_q = [&](const Vector& x) {
    return q.from + (qq > 0 ? clamped(dot(q.along, x - q.from) / qq) : 0) * q.along;
  };
  const auto on_p = [&](const Vector& x) {
    return p.from + (pp > 0 ? clamped(dot(p.along, x - p.from) / pp) : 0) * p.along;
  };
  for (const Vector& end : {p.from, p.from + p.along}) closest.offer(end, on_q(end), {});
  for (const Vector& end : {q.from, q.from + q.along}) closest.offer(on_p(end), end, {});
  const Vector n = cross(p.along, q.along);
  const Real nn = dot(n, n);
  if (!(nn > 4096 * kUnit * kUnit * pp * qq)) return;
  const Vector r = q.from - p.from;
  const Real s = dot(cross(r, q.along), n) / nn, t = dot(cross(r, p.along), n) / nn;
  if (s < 0 || s > 1 || t < 0 || t > 1) return;
  closest.offer(p.from + s * p.along, q.from + t * q.along, (1 / std::sqrt(nn)) * n, std::sqrt(nn / (pp * qq)));
}

Closest closest_features(const ConvexPart& a, const ConvexPart& b, Real slack_m) {
  Closest closest{slack_m};
  vertices_to_faces(a, b, false, closest);
  vertices_to_faces(b, a, true, closest);
  const auto of_a = segments(a), of_b = segments(b);
  for (const Segment& p : of_a)
    for (const Segment& q : of_b) segment_to_segment(p, q, closest);
  return closest;
}

// ---- putting together ---------------------------------------------------------------------------------------------
void round_off(Separation& found, const ConvexPart& a, const ConvexPart& b) {
  found.gap_m -= a.radius_m + b.radius_m;
  found.on_a = found.on_a + a.radius_m * found.normal;
  found.on_b = found.on_b - b.radius_m * found.normal;
}

// `parting`: a separating direction, if one is known.
Separation apart(const ConvexPart& a, const ConvexPart& b, Real coordinates, const Axis* parting = nullptr) {
  const Closest closest = closest_features(a, b, 8 * kUnit * coordinates);
  Separation found;
  Real most = -std::numeric_limits<Real>::infinity();
  for (const Candidate& each : closest.tied) {
    if (each.distance > closest.least_m + closest.slack_m) continue;
    const Vector across = each.on_b - each.on_a;
    const bool of_feature = dot(each.normal, each.normal) > 0;
    // The normal of a feature is exact; the difference of two close points is not.
    Vector n{0, 0, 1};
    if (of_feature) n = (dot(each.normal, across) < 0 ? -1 : 1) * each.normal;
    else if (each.distance > 0) n = (1 / each.distance) * across;
    const Real parted = range(b, n).low - range(a, n).high;
    if (parted <= most) continue;
    most = parted;
    found.normal = n, found.on_a = each.on_a, found.on_b = each.on_b;
    found.gap_m = of_feature ? dot(n, across) : each.distance;
    // s(n) is at most the distance, and the distance of any two points of the parts is at least the distance.
    found.bar_m = 32 * kUnit * coordinates + std::max<Real>(0, closest.least_m - parted);
    // The error of the direction is the round-off of the points over their distance; at a contact it may have the wrong
    // sign, which changes the gap by twice the distance.
    if (of_feature) found.margin_m = std::min(coordinates, 2 * each.distance);
    else found.margin_m = each.distance > 1e6L * found.bar_m ? each.distance : 0;
  }
  if (parting != nullptr && parting->s > most) {  // close points determine the direction less accurately
    const Candidate& least = closest.least();
    found.normal = parting->normal, found.on_a = least.on_a, found.on_b = least.on_b;
    found.gap_m = least.distance;
    found.bar_m = 32 * kUnit * coordinates + std::max<Real>(0, least.distance - parting->s);
    found.margin_m = std::min(coordinates, 2 * least.distance);
  }
  round_off(found, a, b);
  return found;
}

// Mean of the vertices on the support plane, within round-off.
Vector support_mean(const ConvexPart& part, const Vector& n, Real level, Real tolerance, int& count) {
  Vector sum{};
  count = 0;
  for (const Vector& v : part.vertices)
    if (std::fabs(dot(n, v) - level) <= tolerance) sum = sum + v, ++count;
  return (Real(1) / count) * sum;
}

}  // namespace

Separation separation(const ConvexPart& a, const ConvexPart& b, Gap wanted) {
  const Real coordinates = std::max(extent(a), extent(b));
  if (a.dimension + b.dimension < 3) return apart(a, b, coordinates);  // their Minkowski difference has no interior
  const Axes axes(a, b);
  if (axes.empty()) return apart(a, b, coordinates);
  Real margin = 0;
  const Axis& axis = axes.best(margin);
  const Real evaluated = 32 * kUnit * coordinates, bar = evaluated * (1 + 1 / axis.sharpness);
  const Real radii = a.radius_m + b.radius_m;
  if (wanted == Gap::of_overlap && axis.s > evaluated + radii) return {axis.s - radii, axis.normal};
  if (axis.s > evaluated) return apart(a, b, coordinates, &axis);  // s(n) > 0 separates them for every n
  Separation found;
  found.gap_m = axis.s;
  found.normal = axis.normal;
  found.bar_m = bar;
  found.margin_m = std::min(margin, coordinates);
  // The vertex of one and its projection on the support plane of the other; for two edges, their midpoints.
  int corners_a = 0, corners_b = 0;
  const Vector mean_a = support_mean(a, axis.normal, range(a, axis.normal).high, bar, corners_a);
  const Vector mean_b = support_mean(b, axis.normal, range(b, axis.normal).low, bar, corners_b);
  if (corners_a == 2 && corners_b == 2) {
    const auto edge = [&](const ConvexPart& part, const Vector& along, Real level) {
      std::vector<Vector> ends;
      for (const Vector& v : part.vertices)
        if (std::fabs(dot(along, v) - level) <= bar) ends.push_back(v);
      return Segment{ends[0], ends[1] - ends[0]};
    };
    Closest closest;
    const Vector& n = axis.normal;
    segment_to_segment(edge(a, n, range(a, n).high), edge(b, n, range(b, n).low), closest);
    found.on_a = closest.least().on_a, found.on_b = closest.least().on_b;
  } else if (corners_b <= corners_a) {
    found.on_b = mean_b, found.on_a = mean_b - axis.s * axis.normal;
  } else {
    found.on_a = mean_a, found.on_b = mean_a + axis.s * axis.normal;
  }
  round_off(found, a, b);
  return found;
}

Separation above(const ConvexPart& a, const HalfSpace& plane) {
  Separation found;
  const Vector* lowest = &a.vertices.front();
  for (const Vector& v : a.vertices)
    if (dot(plane.normal, v) < dot(plane.normal, *lowest)) lowest = &v;
  found.gap_m = dot(plane.normal, *lowest) - plane.offset_m - a.radius_m;
  found.normal = -1 * plane.normal;
  found.on_a = *lowest - a.radius_m * plane.normal;
  found.on_b = found.on_a - found.gap_m * plane.normal;
  found.bar_m = 32 * kUnit * std::max(extent(a), std::fabs(plane.offset_m));
  found.margin_m = extent(a);
  return found;
}

// Support of a cylinder along n: h |n . axis| + r |n x axis|.
Separation above(const RoundBar& a, const HalfSpace& plane) {
  Separation found;
  const Vector down = -1 * plane.normal;
  const Real along = dot(down, a.axis);
  const Vector across = down - along * a.axis;
  const Real sine = norm(across);
  Vector lowest = a.centre + (along >= 0 ? a.half_length_m : -a.half_length_m) * a.axis;
  if (sine > 0) lowest = lowest + (a.radius_m / sine) * across;
  const Real height = dot(plane.normal, a.centre) - plane.offset_m;
  found.gap_m = height - a.half_length_m * std::fabs(along) - a.radius_m * sine;
  found.normal = down;
  found.on_a = lowest;
  found.on_b = lowest - found.gap_m * plane.normal;
  const Real size = norm(a.centre) + a.radius_m + a.half_length_m + std::fabs(plane.offset_m);
  found.bar_m = 32 * kUnit * size;
  found.margin_m = size;
  return found;
}

// In the half plane (rho, z) of the cylinder and the ball's centre.
Separation from_ball(const Vector& centre, Real radius_m, const RoundBar& b) {
  Separation found;
  const Vector r = centre - b.centre;
  const Real z = dot(r, b.axis);
  const Vector across = r - z * b.axis;
  const Real rho = norm(across);
  const Vector up = (z >= 0 ? Real(1) : Real(-1)) * b.axis;
  Vector out = rho > 0 ? (1 / rho) * across : Vector{};
  const bool on_axis = !(rho > 0);
  if (on_axis) out = norm(cross(b.axis, {1, 0, 0})) > 0.5L ? cross(b.axis, {1, 0, 0}) : cross(b.axis, {0, 1, 0});
  if (on_axis) out = (1 / norm(out)) * out;
  const Real beside = rho - b.radius_m, beyond = std::fabs(z) - b.half_length_m;
  const Real size = norm(r) + b.radius_m + b.half_length_m + radius_m + norm(centre);
  Vector n;  // from the cylinder to the ball
  Real gap;
  if (beside > 0 && beyond > 0) {
    gap = std::hypot(beside, beyond);
    n = (beside / gap) * out + (beyond / gap) * up;
    found.margin_m = gap > 1e6L * 32 * kUnit * size ? gap : 0;
  } else {
    const bool side = beside > beyond;
    gap = side ? beside : beyond;
    n = side ? out : up;
    const bool inside = beside <= 0 && beyond <= 0;
    found.margin_m = inside ? std::fabs(beside - beyond) : size;
    if (inside && side) found.margin_m = std::min(found.margin_m, rho);
    if (inside && !side) found.margin_m = std::min(found.margin_m, std::fabs(z));
  }
  found.gap_m = gap - radius_m;
  found.normal = -1 * n;
  found.on_a = centre - radius_m * n;
  found.on_b = centre - gap * n;
  found.bar_m = 32 * kUnit * size;
  return found;
}

}  // namespace atwood::geometry
