// Spheres against the primitive shapes: one contact point each. Shape a is the sphere, so the contact normal (from a to
// b) is opposite to the direction from the other shape's nearest point to the sphere's centre.
#include "collision/direction.hpp"
#include "collision/pair_tests.hpp"

namespace atwood {

namespace {

// The point of a shape's surface that is nearest to a sphere's centre, in the shape's axes.
template <class S> struct Nearest {
  Vec3<S> on_surface;
  Vec3<S> outward{S(0), S(0), S(1)};  // unit, at that point: the direction in which the centre leaves the shape
  S distance{};                       // of the centre from the surface; negative inside
  std::uint32_t feature = 0;
};

template <class S> S signed_like(S magnitude, S sign) { return sign < S(0) ? -magnitude : magnitude; }

// h: half sizes; c: the centre. A centre outside is clamped to the box; for one inside, the nearest face is taken, and
// of equally near ones z before y before x. A rectangle is a box with h.z = 0: a centre in its plane has the direction
// +z. `feature`: which of the 27 regions, into which the planes of the box's faces divide space, holds the centre.
template <class S> Nearest<S> nearest_on_box(const Vec3<S>& h, const Vec3<S>& c) {
  const auto clamp = [](S x, S most) { return x < -most ? -most : most < x ? most : x; };
  const auto region = [](S x, S most) { return x < -most ? 0u : most < x ? 2u : 1u; };
  Nearest<S> out;
  out.on_surface = {clamp(c.x, h.x), clamp(c.y, h.y), clamp(c.z, h.z)};
  out.distance = length_and_direction(c - out.on_surface, out.outward);
  out.feature = region(c.x, h.x) + 3 * region(c.y, h.y) + 9 * region(c.z, h.z);
  if (out.distance > S(0)) return out;
  const S x = h.x - real::abs(c.x), y = h.y - real::abs(c.y), z = h.z - real::abs(c.z);
  out.on_surface = c;
  if (z <= x && z <= y) {
    out.outward = {S(0), S(0), signed_like(S(1), c.z)};
    out.on_surface.z = signed_like(h.z, c.z);
    out.feature = c.z < S(0) ? 4 : 22;
    out.distance = -z;
  } else if (y <= x) {
    out.outward = {S(0), signed_like(S(1), c.y), S(0)};
    out.on_surface.y = signed_like(h.y, c.y);
    out.feature = c.y < S(0) ? 10 : 16;
    out.distance = -y;
  } else {
    out.outward = {signed_like(S(1), c.x), S(0), S(0)};
    out.on_surface.x = signed_like(h.x, c.x);
    out.feature = c.x < S(0) ? 12 : 14;
    out.distance = -x;
  }
  return out;
}

template <class S> Nearest<S> nearest_on_segment(S half_length, const Vec3<S>& c) {
  const S z = c.z < -half_length ? -half_length : half_length < c.z ? half_length : c.z;
  Nearest<S> out;
  out.on_surface = {S(0), S(0), z};
  out.outward = {S(1), S(0), S(0)};  // for a centre on the axis: any perpendicular direction
  out.distance = length_and_direction(c - out.on_surface, out.outward);
  out.feature = c.z < -half_length ? 1 : half_length < c.z ? 2 : 0;
  return out;
}

template <class S> Nearest<S> nearest_on_cylinder(S radius, S half_length, const Vec3<S>& c) {
  Vec3<S> across{S(1), S(0), S(0)};
  const S rho = length_and_direction(Vec3<S>{c.x, c.y, S(0)}, across);
  const bool beside = radius < rho, beyond = half_length < real::abs(c.z);
  const S cap = signed_like(half_length, c.z);
  Nearest<S> out;
  out.feature = (beside ? 1u : 0u) + (beyond ? (c.z < S(0) ? 2u : 4u) : 0u);
  if (beside && beyond) {
    out.on_surface = radius * across + Vec3<S>{S(0), S(0), cap};
    out.distance = length_and_direction((rho - radius) * across + Vec3<S>{S(0), S(0), c.z - cap}, out.outward);
    return out;
  }
  const S to_side = rho - radius, to_cap = real::abs(c.z) - half_length;  // negative: inside of it
  if (beside || (!beyond && to_side > to_cap)) {
    out.on_surface = radius * across + Vec3<S>{S(0), S(0), c.z};
    out.outward = across;
    out.distance = to_side;
  } else {
    out.on_surface = {c.x, c.y, cap};
    out.outward = {S(0), S(0), signed_like(S(1), c.z)};
    out.distance = to_cap;
  }
  return out;
}

template <class S> Nearest<S> nearest(const Geometry<S>& g, const Vec3<S>& c) {
  switch (g.kind) {
    case ShapeKind::capsule: return nearest_on_segment(g.half_length, c);
    case ShapeKind::cylinder: return nearest_on_cylinder(g.radius, g.half_length, c);
    default: return nearest_on_box(g.half_extents, c);
  }
}

// The radius that lies around the shape's skeleton: a capsule's, about its segment.
template <class S> S rounding(const Geometry<S>& g) { return g.kind == ShapeKind::capsule ? g.radius : S(0); }

template <class S> Separation<S> sphere_shape_separation(const Posed<S>& a, const Posed<S>& b) {
  const Nearest<S> at = nearest(b.shape, to_body(b.pose, a.pose.p_W - b.pose.p_W));
  const Vec3<S> outward_W = to_world(b.pose, at.outward);
  const S gap = at.distance - rounding(b.shape) - a.shape.radius;
  const Vec3<S> on_b_W = b.pose.p_W + (to_world(b.pose, at.on_surface) + rounding(b.shape) * outward_W);
  return {gap, -outward_W, a.pose.p_W - a.shape.radius * outward_W, on_b_W};
}

template <class S>
void sphere_shape_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  const Vec3<S> c = to_body(b.pose, a.pose.p_W - b.pose.p_W);
  const Nearest<S> at = nearest(b.shape, c);
  const S gap = at.distance - rounding(b.shape) - a.shape.radius;
  if (!(gap <= margin)) return;
  const Vec3<S> outward_W = to_world(b.pose, at.outward);
  Manifold<S>& m = out.emplace_back();
  m.normal_W = -outward_W;
  m.count = 1;
  m.points[0] = {a.pose.p_W - (a.shape.radius + gap / S(2)) * outward_W, gap, at.feature};
}

}  // namespace

// ---- sphere against sphere ----------------------------------------------------------------------------------------
// Most tests of a pile of spheres are this one. Far apart is decided without a root: |t|^2 > (1 + 8 eps) max_distance^2
// holds only if |t| > max_distance in spite of every rounding; the root decides all other cases.
template <class S>
void sphere_sphere_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  const Vec3<S> t = b.pose.p_W - a.pose.p_W;
  const S radii = a.shape.radius + b.shape.radius, max_distance = radii + margin;
  if (dot(t, t) > (S(1) + S(8) * real::epsilon<S>()) * (max_distance * max_distance)) return;
  Vec3<S> normal{S(0), S(0), a.shape.radius < b.shape.radius ? S(-1) : S(1)};  // of concentric spheres: any way will do
  const S gap = length_and_direction(t, normal) - radii;
  if (!(gap <= margin)) return;
  Manifold<S>& m = out.emplace_back();
  m.normal_W = normal;
  m.count = 1;
  m.points[0] = {a.pose.p_W + (a.shape.radius + gap / S(2)) * normal, gap, 0};
}

template <class S> Separation<S> sphere_sphere_separation(const Posed<S>& a, const Posed<S>& b) {
  Separation<S> out;
  out.normal_W = {S(0), S(0), a.shape.radius < b.shape.radius ? S(-1) : S(1)};
  out.gap = length_and_direction(b.pose.p_W - a.pose.p_W, out.normal_W) - (a.shape.radius + b.shape.radius);
  out.on_a_W = a.pose.p_W + a.shape.radius * out.normal_W;
  out.on_b_W = b.pose.p_W - b.shape.radius * out.normal_W;
  return out;
}

// ---- sphere against plane -----------------------------------------------------------------------------------------
template <class S>
void sphere_plane_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  const S gap = dot(b.shape.normal_W, a.pose.p_W) - b.shape.offset - a.shape.radius;
  if (!(gap <= margin)) return;
  Manifold<S>& m = out.emplace_back();
  m.normal_W = -b.shape.normal_W;
  m.count = 1;
  m.points[0] = {a.pose.p_W - (a.shape.radius + gap / S(2)) * b.shape.normal_W, gap, 0};
}

template <class S> Separation<S> sphere_plane_separation(const Posed<S>& a, const Posed<S>& b) {
  const Vec3<S>& n = b.shape.normal_W;
  const S height = dot(n, a.pose.p_W) - b.shape.offset;
  return {height - a.shape.radius, -n, a.pose.p_W - a.shape.radius * n, a.pose.p_W - height * n};
}

template <class S>
void sphere_box_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  sphere_shape_contacts(a, b, margin, out);
}
template <class S>
void sphere_capsule_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  sphere_shape_contacts(a, b, margin, out);
}
template <class S>
void sphere_cylinder_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  sphere_shape_contacts(a, b, margin, out);
}
template <class S> Separation<S> sphere_box_separation(const Posed<S>& a, const Posed<S>& b) {
  return sphere_shape_separation(a, b);
}
template <class S> Separation<S> sphere_capsule_separation(const Posed<S>& a, const Posed<S>& b) {
  return sphere_shape_separation(a, b);
}
template <class S> Separation<S> sphere_cylinder_separation(const Posed<S>& a, const Posed<S>& b) {
  return sphere_shape_separation(a, b);
}

#define ATWOOD_SPHERE_PAIR(S, other)                                                                          \
  template void sphere_##other##_contacts<S>(const Posed<S>&, const Posed<S>&, S, std::vector<Manifold<S>>&); \
  template Separation<S> sphere_##other##_separation<S>(const Posed<S>&, const Posed<S>&);
#define ATWOOD_SPHERE_PAIRS(S)  \
  ATWOOD_SPHERE_PAIR(S, sphere) \
  ATWOOD_SPHERE_PAIR(S, plane) ATWOOD_SPHERE_PAIR(S, box) ATWOOD_SPHERE_PAIR(S, capsule) ATWOOD_SPHERE_PAIR(S, cylinder)
ATWOOD_SPHERE_PAIRS(float)
ATWOOD_SPHERE_PAIRS(double)
ATWOOD_SPHERE_PAIRS(long double)
#undef ATWOOD_SPHERE_PAIRS
#undef ATWOOD_SPHERE_PAIR

}  // namespace atwood
