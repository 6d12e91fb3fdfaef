#include "contact/event/features.hpp"

#include "contact/event/edges.hpp"

namespace atwood::event {

namespace {

template <class S> Vec3<S> unit_axis(int i, S sign) {
  Vec3<S> e;
  component(e, i) = sign;
  return e;
}

// Of a box or a rectangle: the number of axes along which c lies outside decides between face, edge and vertex. Inside:
// the face of least depth.
template <class S> Facet<S> nearest_of_slab(const Vec3<S>& half, const Vec3<S>& c) {
  Facet<S> facet;
  int outside = 0, last = 0, along = 0;
  S shallowest = S(0);
  for (int i = 0; i < 3; ++i) {
    const S x = component(c, i), h = component(half, i), depth = real::abs(x) - h;
    if (depth > S(0)) {
      ++outside;
      component(facet.point_B, i) = x > S(0) ? h : -h;
      if (outside == 1 || depth > S(0)) last = i;
    } else {
      component(facet.point_B, i) = x;
      along = i;
    }
    if (i == 0 || depth > shallowest) {
      shallowest = depth;
      if (outside == 0) last = i;
    }
  }
  facet.dimension = outside == 0 ? 2 : 3 - outside;
  if (facet.dimension == 2) {
    const S sign = component(c, last) < S(0) ? S(-1) : S(1);
    facet.direction_B = unit_axis<S>(last, sign);
    facet.point_B = component(half, last) * facet.direction_B;
  } else if (facet.dimension == 1) {
    facet.direction_B = unit_axis<S>(along, S(1));
    component(facet.point_B, along) = S(0);
  }
  return facet;
}

// A vertex's body may lie beyond several faces; the vertex is over, or hardly below, only one of them. -1: over none.
template <class S> int face_at_vertex(const Vec3<S>& half, const Vec3<S>& c, const Vec3<S>& side) {
  int face = -1, outside = 0;
  S out{};
  for (int i = 0; i < 3; ++i) {
    const S h = component(half, i), beyond = real::abs(component(side, i)) - h;
    const S over = (component(side, i) < S(0) ? -component(c, i) : component(c, i)) - h;
    outside += beyond > S(0) ? over > S(0) : real::abs(component(c, i)) > h;
    if (!(beyond > S(0)) || (face >= 0 && over <= out)) continue;
    face = i;
    out = over;
  }
  const S smallest = real::min(component(half, (face + 1) % 3), component(half, (face + 2) % 3));
  if (face < 0 || outside > 1 || (outside == 1 && !(out > S(0)))) return -1;
  return out > -smallest / S(64) ? face : -1;
}

// The face below a vertex, on the side of its body.
template <class S> Facet<S> face_of_slab(const Vec3<S>& half, const Vec3<S>& c, const Vec3<S>& side, S& outside_m) {
  int face = 2;
  S most{};
  for (int i = 0; i < 3; ++i) {
    const S out = real::abs(component(side, i)) - component(half, i);
    if (i == 0 || out > most) {
      most = out;
      face = i;
    }
  }
  if (const int at = face_at_vertex(half, c, side); at >= 0) face = at;
  const S sign = component(side, face) < S(0) ? S(-1) : S(1);
  outside_m = S(0);
  for (int i = 0; i < 3; ++i)
    if (i != face) outside_m = real::max(outside_m, real::abs(component(c, i)) - component(half, i));
  const Vec3<S> normal = unit_axis<S>(face, sign);
  return {2, component(half, face) * normal, normal};
}

// C. Ericson, Real-Time Collision Detection (2005), 5.1.5.
template <class S> Facet<S> nearest_of_triangle(const FacetTriangle<S>& triangle, const Vec3<S>& c) {
  const Vec3<S>&A = triangle.corner_B[0], &B = triangle.corner_B[1], &C = triangle.corner_B[2];
  const Vec3<S> ab = B - A, ac = C - A, ap = c - A, bp = c - B, cp = c - C;
  const S d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp), d6 = dot(ac, cp);
  const auto line = [](const Vec3<S>& from, const Vec3<S>& along) {
    return Facet<S>{1, from, (S(1) / norm(along)) * along};
  };
  if (d1 <= S(0) && d2 <= S(0)) return {0, A, {}};
  if (d3 >= S(0) && d4 <= d3) return {0, B, {}};
  if (d6 >= S(0) && d5 <= d6) return {0, C, {}};
  if (d1 * d4 - d3 * d2 <= S(0) && d1 >= S(0) && d3 <= S(0)) return line(A, ab);
  if (d5 * d2 - d1 * d6 <= S(0) && d2 >= S(0) && d6 <= S(0)) return line(A, ac);
  if (d3 * d6 - d5 * d4 <= S(0) && d4 - d3 >= S(0) && d5 - d6 >= S(0)) return line(B, C - B);
  return {2, A, dot(triangle.normal_B, ap) < S(0) ? -triangle.normal_B : triangle.normal_B};
}

template <class S> S distance_to(const Facet<S>& facet, const Vec3<S>& c) {
  Vec3<S> away = c - facet.point_B;
  if (facet.dimension == 2) return real::abs(dot(away, facet.direction_B));
  if (facet.dimension == 1) away -= dot(away, facet.direction_B) * facet.direction_B;
  return norm(away);
}

// At equal distance a face comes before edges and vertices: edges inside a flat mesh are not edges, and a point right
// above one belongs to a face.
template <class S> Facet<S> nearest_of_mesh(const std::vector<FacetTriangle<S>>& mesh, const Vec3<S>& c) {
  Facet<S> best;
  S least = S(-1);
  for (const FacetTriangle<S>& triangle : mesh) {
    const Facet<S> facet = nearest_of_triangle(triangle, c);
    const S distance = distance_to(facet, c);
    const S round_off = S(8) * real::epsilon<S>() * (norm(c) + distance);
    const bool nearer = least < S(0) || distance < least - round_off;
    if (nearer || (distance <= least + round_off && facet.dimension > best.dimension)) {
      best = facet;
      least = nearer ? distance : real::min(least, distance);
    }
  }
  if (best.dimension == 2) return best;
  const S round_off = S(8) * real::epsilon<S>() * (norm(c) + least);
  for (const FacetTriangle<S>& triangle : mesh) {
    const S above = dot(triangle.normal_B, c - triangle.corner_B[0]);
    if (real::abs(above) <= least + round_off && depth_inside_triangle(triangle, c) >= -round_off)
      return {2, triangle.corner_B[0], above < S(0) ? -triangle.normal_B : triangle.normal_B};
  }
  return best;
}

// A point inside is nearest to the face of least depth.
template <class S> Facet<S> nearest_of_hull(const std::vector<FacetTriangle<S>>& hull, const Vec3<S>& c) {
  const FacetTriangle<S>* shallowest = nullptr;
  S most{};
  for (const FacetTriangle<S>& triangle : hull) {
    const S above = dot(triangle.normal_B, c - triangle.corner_B[0]);
    if (shallowest != nullptr && above <= most) continue;
    most = above;
    shallowest = &triangle;
  }
  if (most > S(0)) return nearest_of_mesh(hull, c);
  return {2, shallowest->corner_B[0], shallowest->normal_B};
}

template <class S>
Facet<S> face_of_mesh(const std::vector<FacetTriangle<S>>& mesh, const Vec3<S>& c, const Vec3<S>& side, S& outside_m) {
  Facet<S> facet = nearest_of_mesh(mesh, c);
  outside_m = facet.dimension == 2 ? S(0) : distance_to(facet, c);
  if (facet.dimension == 2 && dot(facet.direction_B, side - facet.point_B) < S(0))
    facet.direction_B = -facet.direction_B;
  return facet;
}

template <class S, bool with_rates>
void sphere_kinematics(const ContactFeature<S>& feature, const Pose<S>& of, const Surface<S>& surface,
                       const Facet<S>& facet, const Pose<S>& on, GapKinematics<S>& kinematics) {
  kinematics.normal_dot = {};
  const Vec3<S> arm = feature.centered ? Vec3<S>{} : to_world(of, feature.center_B);
  const Vec3<S> center = of.p + arm;
  const Vec3<S> center_dot = feature.centered ? of.v : of.v + cross(of.w, arm);
  if (surface.kind == SurfaceKind::plane) {
    kinematics.normal = surface.normal_W;
    kinematics.gap = dot(surface.normal_W, center) - surface.offset - feature.radius;
    kinematics.rate = dot(surface.normal_W, center_dot);
    kinematics.x = center - feature.radius * kinematics.normal;
    if (with_rates) kinematics.x_dot = center_dot;
    return;
  }
  const Vec3<S> from_body = center - on.p;
  Vec3<S> away, along;
  if (surface.kind == SurfaceKind::point) away = from_body;
  else {
    away = from_body - to_world(on, facet.point_B);
    along = to_world(on, facet.direction_B);
  }
  const Vec3<S> relative_velocity =
      center_dot - on.v - (surface.kind == SurfaceKind::point ? cross(on.w, Vec3<S>{}) : cross(on.w, from_body));
  S distance{};
  Vec3<S> across{};  // the relative velocity that turns the normal
  if (facet.dimension == 2) {
    kinematics.normal = along;
    distance = dot(along, away);
  } else {
    if (facet.dimension == 1) away -= dot(away, along) * along;
    distance = norm(away);
    kinematics.normal = distance > S(0) ? (S(1) / distance) * away : Vec3<S>{S(0), S(0), S(1)};
    across = relative_velocity - dot(relative_velocity, kinematics.normal) * kinematics.normal;
    if (facet.dimension == 1) across -= dot(relative_velocity, along) * along;
  }
  kinematics.rate = dot(kinematics.normal, relative_velocity);
  kinematics.gap = distance - feature.radius - surface.radius;
  kinematics.x = center - feature.radius * kinematics.normal;
  if (with_rates) {
    if (surface.kind != SurfaceKind::point) kinematics.normal_dot = cross(on.w, kinematics.normal);
    if (distance != S(0) && facet.dimension < 2) kinematics.normal_dot += (S(1) / distance) * across;
    kinematics.x_dot = center_dot - feature.radius * kinematics.normal_dot;
  }
}

// The lowest point of a circle about the unit axis a over a face: x = c - R e, e = (n - (n.a) a) / s with s its length.
// It moves with the rotation of n, too. Where a is parallel to n, x = c.
template <class S, bool with_rates>
void circle_kinematics(const ContactFeature<S>& feature, const Pose<S>& of, const Surface<S>& surface,
                       const Facet<S>& facet, const Pose<S>& on, GapKinematics<S>& kinematics) {
  kinematics.normal_dot = kinematics.x_dot = {};
  const bool plane = surface.kind == SurfaceKind::plane;
  const Vec3<S> arm = to_world(of, feature.center_B), axis = to_world(of, feature.axis_B),
                n = plane ? surface.normal_W : to_world(on, facet.direction_B);
  const Vec3<S> center = of.p + arm;
  const S tilt_cosine = dot(n, axis);
  const Vec3<S> up = n - tilt_cosine * axis;
  const S tilt = norm(up), s = tilt > tilt_round_off<S>() ? tilt : S(0);
  const Vec3<S> e = s > S(0) ? (S(1) / s) * up : Vec3<S>{};
  kinematics.normal = n;
  kinematics.x = center - feature.radius * e;
  const S above =
      plane ? dot(n, center) - surface.offset : dot(n, center - on.p) - dot(facet.direction_B, facet.point_B);
  kinematics.gap = above - feature.radius * s;
  kinematics.rate = dot(n, of.v + cross(of.w, kinematics.x - of.p));
  if (!plane) kinematics.rate -= dot(n, on.v + cross(on.w, kinematics.x - on.p));
  if (!with_rates) return;
  if (!plane) kinematics.normal_dot = cross(on.w, n);
  kinematics.x_dot = of.v + cross(of.w, arm);
  if (!(s > S(0))) return;
  const Vec3<S> axis_dot = cross(of.w, axis), &n_dot = kinematics.normal_dot;
  const Vec3<S> up_dot = n_dot - (dot(n_dot, axis) + dot(n, axis_dot)) * axis - tilt_cosine * axis_dot;
  kinematics.x_dot -= (feature.radius / s) * (up_dot - dot(e, up_dot) * e);
}

}  // namespace

template <class S> S depth_inside_triangle(const FacetTriangle<S>& triangle, const Vec3<S>& at_B) {
  S least{};
  for (int i = 0; i < 3; ++i) {
    const Vec3<S>& from = triangle.corner_B[i];
    const Vec3<S> inward = cross(triangle.normal_B, triangle.corner_B[(i + 1) % 3] - from);
    const S in = dot(inward, at_B - from) / norm(inward);
    least = i == 0 ? in : real::min(least, in);
  }
  return least;
}

template <class S>
Facet<S> nearest_facet(const Surface<S>& surface, const Vec3<S>& center_B, bool corner, const Vec3<S>& side_B,
                       S& outside_m) {
  outside_m = S(0);
  switch (surface.kind) {
    case SurfaceKind::plane: return {2, {}, {}};
    case SurfaceKind::point: return {0, {}, {}};
    case SurfaceKind::segment: {
      const S h = surface.half_extents.z;
      if (center_B.z > h) return {0, {S(0), S(0), h}, {}};
      if (center_B.z < -h) return {0, {S(0), S(0), -h}, {}};
      return {1, {}, {S(0), S(0), S(1)}};
    }
    case SurfaceKind::slab:
      return corner ? face_of_slab(surface.half_extents, center_B, side_B, outside_m)
                    : nearest_of_slab(surface.half_extents, center_B);
    case SurfaceKind::mesh:
    case SurfaceKind::edge: break;
  }
  if (surface.convex) return nearest_of_hull(surface.mesh, center_B);
  return corner ? face_of_mesh(surface.mesh, center_B, side_B, outside_m) : nearest_of_mesh(surface.mesh, center_B);
}

template <class S>
Vec3<S> lowest_point_of_circle(const ContactFeature<S>& feature, const Pose<S>& of, const Vec3<S>& n_W) {
  const Vec3<S> center = of.p + to_world(of, feature.center_B), axis = to_world(of, feature.axis_B);
  const Vec3<S> up = n_W - dot(n_W, axis) * axis;
  const S s = norm(up);
  return s > tilt_round_off<S>() ? center - (feature.radius / s) * up : center;
}

template <class S>
GapKinematics<S> gap_kinematics(const ContactFeature<S>& feature, const Pose<S>& of, const Surface<S>& surface,
                                const Facet<S>& facet, const Pose<S>& on) {
  GapKinematics<S> kinematics;
  if (feature.edge) edge_kinematics(feature, of, facet, on, false, kinematics);
  else if (feature.circle) circle_kinematics<S, false>(feature, of, surface, facet, on, kinematics);
  else sphere_kinematics<S, false>(feature, of, surface, facet, on, kinematics);
  return kinematics;
}
template <class S>
void gap_kinematics_with_rates(const ContactFeature<S>& feature, const Pose<S>& of, const Surface<S>& surface,
                               const Facet<S>& facet, const Pose<S>& on, GapKinematics<S>& kinematics) {
  if (feature.edge) edge_kinematics(feature, of, facet, on, true, kinematics);
  else if (feature.circle) circle_kinematics<S, true>(feature, of, surface, facet, on, kinematics);
  else sphere_kinematics<S, true>(feature, of, surface, facet, on, kinematics);
}

#define ATWOOD_FEATURES(S)                                                                                 \
  template Vec3<S> lowest_point_of_circle<S>(const ContactFeature<S>&, const Pose<S>&, const Vec3<S>&);    \
  template S depth_inside_triangle<S>(const FacetTriangle<S>&, const Vec3<S>&);                            \
  template Facet<S> nearest_facet<S>(const Surface<S>&, const Vec3<S>&, bool, const Vec3<S>&, S&);         \
  template GapKinematics<S> gap_kinematics<S>(const ContactFeature<S>&, const Pose<S>&, const Surface<S>&, \
                                              const Facet<S>&, const Pose<S>&);                            \
  template void gap_kinematics_with_rates<S>(const ContactFeature<S>&, const Pose<S>&, const Surface<S>&,  \
                                             const Facet<S>&, const Pose<S>&, GapKinematics<S>&);
ATWOOD_FEATURES(float)
ATWOOD_FEATURES(double)
ATWOOD_FEATURES(long double)
#undef ATWOOD_FEATURES

}  // namespace atwood::event
