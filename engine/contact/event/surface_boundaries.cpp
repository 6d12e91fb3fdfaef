// Boundaries of faces and lines. A contact leaves its facet there: a sphere that rolls over the boundary of a face
// moves on to the edge, or separates; a box goes on where its edges cross those that it slides over (edges.hpp).
// Vertices of other bodies have contacts with faces only, so a body that overlaps a boundary without a contact there,
// or is larger than the whole face, is refused.
#include "contact/event/surface_boundaries.hpp"

#include <algorithm>
#include <cmath>

#include "collision/contacts.hpp"
#include "contact/event/edge_candidates.hpp"

namespace atwood::event {

namespace {

// Depth of c inside the face formed by the coplanar triangles: the largest depth in any of them; negative outside. Sets
// `over` to that triangle, and tries `over` first: if c is inside it, its depth is returned.
template <class S>
S depth_inside_face(const std::vector<FacetTriangle<S>>& mesh, const Facet<S>& facet, const Vec3<S>& c, S tiny,
                    int& over) {
  const int count = static_cast<int>(mesh.size());
  const auto on_the_face = [&](const FacetTriangle<S>& triangle) {
    return std::all_of(triangle.corner_B, triangle.corner_B + 3, [&](const Vec3<S>& corner) {
      return real::abs(dot(corner - facet.point_B, facet.direction_B)) <= tiny;
    });
  };
  if (over < count && on_the_face(mesh[over]))
    if (const S in = depth_inside_triangle(mesh[over], c); in > S(0)) return in;
  S most = S(-1);
  bool any = false;
  for (int i = 0; i < count; ++i) {
    if (!on_the_face(mesh[i])) continue;
    const S in = depth_inside_triangle(mesh[i], c);
    if (!any || in > most) {
      most = in;
      over = i;
    }
    any = true;
  }
  return most;
}

// Of a box or a rectangle, the least distance by which c stays in the region of the facet: within the face's sides, or
// outside along the axes that meet at the edge or vertex.
template <class S> S depth_inside_slab(const Vec3<S>& half, const Facet<S>& facet, const Vec3<S>& c) {
  S least{};
  bool any = false;
  for (int i = 0; i < 3; ++i) {
    const bool along = component(facet.direction_B, i) != S(0);
    if (facet.dimension == 2 && along) continue;
    const S inside = component(half, i) - real::abs(component(c, i));
    const S value = facet.dimension == 2 || along ? inside : -inside;
    least = any ? real::min(least, value) : value;
    any = true;
  }
  return least;
}

template <class S> bool same_facet(const Facet<S>& a, const Facet<S>& b) {
  return a.dimension == b.dimension && norm(a.point_B - b.point_B) == S(0) &&
         norm(a.direction_B - b.direction_B) == S(0);
}

// True for unrounded pairs and features off the body's origin, whose contacts are with faces only.
template <class S> bool meets_faces_only(const Surface<S>& surface, const ContactFeature<S>& feature) {
  return surface.radius + feature.radius == S(0) || !feature.centered;  // the condition of facet_below()
}

}  // namespace

template <class S> bool has_boundary(const Proximity<S>& proximity, const Contact<S>& contact) {
  return proximity.surfaces[proximity.candidates[contact.candidate].surface].kind > SurfaceKind::point;
}

template <class S>
GapKinematics<S> held_kinematics(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact) {
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  return gap_kinematics(candidate.feature, bodies.poses[candidate.feature_body], proximity.surfaces[candidate.surface],
                        contact.facet, bodies.poses[candidate.surface_body]);
}

namespace {

// Up to what a step drifts before it is projected.
template <class S> bool same_normal(const Vec3<S>& one, const Vec3<S>& other) {
  static const S tolerance = std::cbrt(real::epsilon<S>());
  return norm(one - other) <= tolerance;
}

// Does another active contact of the pair have that normal? Two points of an edge that lies on a face do.
template <class S>
bool shares_normal(const Proximity<S>& proximity, const ActiveSet<S>& active, const Contact<S>& contact) {
  return std::any_of(active.contacts.begin(), active.contacts.end(), [&](const Contact<S>& other) {
    return other.active && other.candidate != contact.candidate &&
           proximity.candidates[other.candidate].pair == proximity.candidates[contact.candidate].pair &&
           same_normal(other.kinematics.normal, contact.kinematics.normal);
  });
}

// A contact of two edges at the end of its facet: does it last, because one edge now lies on a face of the other's
// body?
template <class S> bool stays_on_face(EventRun<S>& run, const Contact<S>& contact) {
  Bodies<S>& bodies = run.bodies;
  const Candidate<S>& candidate = run.proximity.candidates[contact.candidate];
  if (!candidate.feature.edge) return false;
  update_poses(bodies, candidate, run.states.y.data());
  const EdgeDepths<S> depths = depths_inside_edges_of(bodies, run.proximity, contact);
  if (depths.to_ends < -bodies.gap_round_off()) return false;
  if (depths.to_face >= -bodies.gap_round_off()) return true;
  const GapKinematics<S> held = held_kinematics(bodies, run.proximity, contact);
  const ShapePair<S>& pair = run.proximity.pairs[candidate.pair];
  for (int f = pair.first; f < pair.first + pair.count; ++f) {
    if (f == contact.candidate) continue;
    const GapKinematics<S> other = gap_from_poses(bodies, run.proximity, run.proximity.candidates[f]);
    if (other.gap <= bodies.gap_round_off() && same_normal(other.normal, held.normal)) return true;
  }
  return false;
}

}  // namespace

template <class S>
S depth_inside_facet(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                     Contact<S>& contact) {
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  if (candidate.feature.edge) {
    const EdgeDepths<S> depths = depths_inside_edges_of(bodies, proximity, contact);
    return shares_normal(proximity, active, contact) ? depths.to_ends : real::min(depths.to_ends, depths.to_face);
  }
  const Surface<S>& surface = proximity.surfaces[candidate.surface];
  const Facet<S>& facet = contact.facet;
  const Pose<S>& on = bodies.poses[candidate.surface_body];
  const Vec3<S> c = to_body(on, reference_point(bodies, proximity, candidate) - on.p);
  switch (surface.kind) {
    case SurfaceKind::segment: {
      const S inside = surface.half_extents.z - real::abs(c.z);
      return facet.dimension == 1 ? inside : -inside;
    }
    case SurfaceKind::slab: return depth_inside_slab(surface.half_extents, facet, c);
    case SurfaceKind::mesh: {
      if (facet.dimension == 2)
        return depth_inside_face(surface.mesh, facet, c, bodies.gap_round_off(), contact.last_triangle);
      S outside_m{};
      const Facet<S> nearest = facet_below(bodies, proximity, candidate, outside_m);
      if (same_facet(nearest, facet)) return bodies.length_scale;
      return nearest.dimension == 2
                 ? -depth_inside_face(surface.mesh, nearest, c, bodies.gap_round_off(), contact.last_triangle)
                 : -bodies.length_scale;
    }
    default: return S(1);
  }
}

template <class S>
S leaving_speed(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate) {
  const Surface<S>& surface = proximity.surfaces[candidate.surface];
  if (surface.kind != SurfaceKind::slab || candidate.feature.edge || !has_edges(proximity, candidate.pair)) return S(0);
  S outside_m{};
  const Facet<S> facet = facet_below(bodies, proximity, candidate, outside_m);
  if (facet.dimension != 2) return S(0);
  const Pose<S>&of = bodies.poses[candidate.feature_body], &on = bodies.poses[candidate.surface_body];
  const Vec3<S> x = reference_point(bodies, proximity, candidate);
  const Vec3<S> at = to_body(on, x - on.p),
                u = to_body(on, (of.v + cross(of.w, x - of.p)) - (on.v + cross(on.w, x - on.p)));
  S fastest = S(0);
  for (int i = 0; i < 3; ++i) {
    if (component(facet.direction_B, i) != S(0)) continue;
    const S place = component(at, i), outward = place < S(0) ? -component(u, i) : component(u, i);
    if (real::abs(component(surface.half_extents, i) - real::abs(place)) <= bodies.gap_round_off() &&
        outward > bodies.slip_round_off())
      fastest = real::max(fastest, outward);
  }
  return fastest;
}

template <class S>
bool leaves_without_impact(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate,
                           S rate) {
  constexpr S steepest = S(16);  // clear_of_boundary() allows four times as much
  const S speed = leaving_speed(bodies, proximity, candidate);
  return speed > S(0) && -rate <= steepest * speed;
}

template <class S>
bool overlaps_other_facet(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact,
                          const S* y) {
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  const Surface<S>& surface = proximity.surfaces[candidate.surface];
  const Pose<S> of = pose_of(bodies, candidate.feature_body, y), on = pose_of(bodies, candidate.surface_body, y);
  const Vec3<S> center = of.p + to_world(of, candidate.feature.center_B);
  S outside_m{};
  const Facet<S> nearest = nearest_facet(surface, to_body(on, center - on.p), false, Vec3<S>{}, outside_m);
  const S held = gap_kinematics(candidate.feature, of, surface, contact.facet, on).gap;
  return gap_kinematics(candidate.feature, of, surface, nearest, on).gap <
         real::min(held, contact.target_gap) - S(16) * bodies.gap_round_off();
}

template <class S> bool change_facet(EventRun<S>& run, Contact<S>& contact) {
  const Bodies<S>& bodies = run.bodies;
  Proximity<S>& proximity = run.proximity;
  // A vertex or an edge that leaves its facet has no contact any more; the body may then stand on other candidates.
  if (const int pair = proximity.candidates[contact.candidate].pair; has_edges(proximity, pair)) {
    add_edge_candidates(proximity, run.active, run.impacts, pair);
    if (stays_on_face(run, contact)) return true;
    proximity.candidates[contact.candidate].in_contact = false;
    contact.left_facet = true;
    return true;
  }
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  if (meets_faces_only(proximity.surfaces[candidate.surface], candidate.feature))
    return end_run(run.report, Status::unsupported, proximity.pairs[candidate.pair].boundary_refusal);
  // By round-off the feature is still over the old facet: take the one a little ahead.
  const Pose<S>&of = bodies.poses[candidate.feature_body], &on = bodies.poses[candidate.surface_body];
  const Vec3<S> arm = candidate.feature.centered ? Vec3<S>{} : to_world(of, candidate.feature.center_B),
                center = of.p + arm;
  const Vec3<S> drift = of.v + cross(of.w, arm) - on.v - cross(on.w, center - on.p);
  const S speed = norm(drift), ahead_m = S(2) * bodies.gap_round_off();
  const Vec3<S> ahead = speed > S(0) ? center + (ahead_m / speed) * drift : center;
  S outside_m{};
  contact.facet = nearest_facet(proximity.surfaces[candidate.surface], to_body(on, ahead - on.p), false,
                                to_body(on, of.p - on.p), outside_m);
  return true;
}

namespace {

template <class S> Transform<S> transform_of(const Bodies<S>& bodies, int body, const S* y) {
  const Pose<S> pose = pose_of(bodies, body, y);
  return {pose.p, {pose.axis[0], pose.axis[1], pose.axis[2]}};
}

}  // namespace

template <class S>
S target_gap_of_pair(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active, int pair,
                     const S* y) {
  S deepest = S(0);
  for (const Contact<S>& contact : active.contacts) {
    const Candidate<S>& candidate = proximity.candidates[contact.candidate];
    if (candidate.pair != pair) continue;
    deepest = real::min(deepest, contact.target_gap);
    if (!contact.active) continue;
    const Pose<S> of = pose_of(bodies, candidate.feature_body, y), on = pose_of(bodies, candidate.surface_body, y);
    deepest = real::min(
        deepest, gap_kinematics(candidate.feature, of, proximity.surfaces[candidate.surface], contact.facet, on).gap);
  }
  return deepest;
}

template <class S>
bool clear_of_boundary(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                       const FaceBoundary<S>& boundary, const S* y) {
  const ShapePair<S>& pair = proximity.pairs[boundary.pair];
  if (std::find(proximity.near.begin(), proximity.near.end(), boundary.pair) == proximity.near.end()) return true;
  const Transform<S> feature = transform_of(bodies, boundary.feature_body, y),
                     sheet = transform_of(bodies, boundary.surface_body, y);
  if (norm(feature.p_W - sheet.p_W) > pair.bounding_radii) return true;
  // separation() is iterative: allow eps^0.6 of the pair's size.
  const S iterated = S(std::pow(static_cast<double>(real::epsilon<S>()), 0.6));
  const S tolerance = S(64) * bodies.gap_round_off() + iterated * pair.bounding_radii;
  return separation(boundary.feature, feature, boundary.surface, sheet).gap >=
         target_gap_of_pair(bodies, proximity, active, boundary.pair, y) - tolerance;
}

template <class S>
bool clear_of_boundaries(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                         Report& report, const S* y) {
  for (const FaceBoundary<S>& boundary : proximity.boundaries)
    if (!clear_of_boundary(bodies, proximity, active, boundary, y))
      return end_run(report, Status::unsupported, proximity.pairs[boundary.pair].boundary_refusal);
  return true;
}

template <class S>
bool may_cross_boundary(const Bodies<S>& bodies, const Proximity<S>& proximity, const S* y, const S* y_end) {
  // Close to each other, has one rotated? A body that tips over a boundary may be clear of it again.
  const auto turned_much = [&](int body) {
    const Pose<S> from = pose_of(bodies, body, y), to = pose_of(bodies, body, y_end);
    S most = S(0);
    for (int k = 0; k < 3; ++k) most = real::max(most, norm(to.axis[k] - from.axis[k]));
    return most > S(0.05);
  };
  return std::any_of(proximity.boundaries.begin(), proximity.boundaries.end(), [&](const FaceBoundary<S>& boundary) {
    const Transform<S> one = transform_of(bodies, boundary.feature_body, y),
                       other = transform_of(bodies, boundary.surface_body, y);
    if (norm(one.p_W - other.p_W) < proximity.pairs[boundary.pair].bounding_radii &&
        (turned_much(boundary.feature_body) || turned_much(boundary.surface_body)))
      return true;
    const auto side = [&](const S* at) {
      const Transform<S> sheet = transform_of(bodies, boundary.surface_body, at);
      return dot(to_world(sheet, boundary.normal_B), transform_of(bodies, boundary.feature_body, at).p_W - sheet.p_W) -
             dot(boundary.normal_B, boundary.on_it_B);
    };
    // Has their relative position changed by a large part of the smaller size? Then a part of a body may have passed.
    const auto apart = [&](const S* at) {
      return transform_of(bodies, boundary.feature_body, at).p_W - transform_of(bodies, boundary.surface_body, at).p_W;
    };
    const S size =
        real::min(bodies.bounding_radius[boundary.feature_body], bodies.bounding_radius[boundary.surface_body]);
    if (boundary.thick || has_edges(proximity, boundary.pair))
      if (norm(apart(y_end) - apart(y)) > size / S(32) &&
          norm(apart(y)) < S(2) * proximity.pairs[boundary.pair].bounding_radii)
        return true;
    if (boundary.thick) return false;
    return side(y) * side(y_end) < S(0);
  });
}

#define ATWOOD_SURFACE_BOUNDARIES(S)                                                                                   \
  template S target_gap_of_pair<S>(const Bodies<S>&, const Proximity<S>&, const ActiveSet<S>&, int, const S*);         \
  template bool clear_of_boundary<S>(const Bodies<S>&, const Proximity<S>&, const ActiveSet<S>&,                       \
                                     const FaceBoundary<S>&, const S*);                                                \
  template bool clear_of_boundaries<S>(const Bodies<S>&, const Proximity<S>&, const ActiveSet<S>&, Report&, const S*); \
  template bool may_cross_boundary<S>(const Bodies<S>&, const Proximity<S>&, const S*, const S*);                      \
  template bool has_boundary<S>(const Proximity<S>&, const Contact<S>&);                                               \
  template S depth_inside_facet<S>(const Bodies<S>&, const Proximity<S>&, const ActiveSet<S>&, Contact<S>&);           \
  template GapKinematics<S> held_kinematics<S>(const Bodies<S>&, const Proximity<S>&, const Contact<S>&);              \
  template bool overlaps_other_facet<S>(const Bodies<S>&, const Proximity<S>&, const Contact<S>&, const S*);           \
  template S leaving_speed<S>(const Bodies<S>&, const Proximity<S>&, const Candidate<S>&);                             \
  template bool leaves_without_impact<S>(const Bodies<S>&, const Proximity<S>&, const Candidate<S>&, S);               \
  template bool change_facet<S>(EventRun<S>&, Contact<S>&);
ATWOOD_SURFACE_BOUNDARIES(float)
ATWOOD_SURFACE_BOUNDARIES(double)
ATWOOD_SURFACE_BOUNDARIES(long double)
#undef ATWOOD_SURFACE_BOUNDARIES

}  // namespace atwood::event
