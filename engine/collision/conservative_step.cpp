// Mirtich (1996) bounds how fast a gap can close by the speed of the fastest point. Near a grazing contact, or under a
// rotation that moves little of the body along the normal, steps by that bound shrink with the gap itself. Here the
// speed is that of the support function, and only the acceleration of the points on their circles is bounded, so that
// steps shrink with the square root of the gap.
#include "collision/conservative_step.hpp"

#include <limits>

#include "collision/convex_part.hpp"
#include "collision/mesh_queries.hpp"
#include "collision/nearest_features.hpp"

namespace atwood {
namespace {

template <class S> S box_support(const Vec3<S>& h, const Vec3<S>& d) {
  return h.x * real::abs(d.x) + h.y * real::abs(d.y) + h.z * real::abs(d.z);
}

// max of d . x over the shape's core (a rotation does not move the radius around it); d in body axes, of any length.
template <class S> S core_support(const Geometry<S>& g, const Vec3<S>& d) {
  switch (g.kind) {
    case ShapeKind::rectangle:
    case ShapeKind::box: return box_support(g.half_extents, d);
    case ShapeKind::capsule: return g.half_length * real::abs(d.z);
    case ShapeKind::cylinder: return g.half_length * real::abs(d.z) + g.radius * norm(Vec3<S>{d.x, d.y, S(0)});
    case ShapeKind::convex: return dot(d, g.hull->vertices[farthest_vertex(*g.hull, d)]);
    case ShapeKind::mesh:
    case ShapeKind::compound: {
      S most = -std::numeric_limits<S>::infinity();
      if (g.mesh)
        for (const Vec3<S>& p : g.mesh->points) most = real::max(most, dot(d, p));
      for (const auto& part : g.parts) {
        const Transform<S> pose = transform(part.p_B, part.q_BP);
        most = real::max(most, dot(d, pose.p_W) + box_support(part.half_extents, to_body(pose, d)));
      }
      return most;
    }
    default: return S(0);
  }
}

template <class S> S box_axis_distance(const Vec3<S>& h, const Transform<S>& pose, const Vec3<S>& u) {
  S most = S(0);
  for (int i = 0; i < 8; ++i) {
    const Vec3<S> corner{i & 1 ? h.x : -h.x, i & 2 ? h.y : -h.y, i & 4 ? h.z : -h.z};
    most = real::max(most, norm(cross(u, point_to_world(pose, corner))));
  }
  return most;
}

// The largest distance of the core from a line along unit u through the body's origin; u in body axes.
template <class S> S core_axis_distance(const Geometry<S>& g, const Vec3<S>& u) {
  S most = S(0);
  switch (g.kind) {
    case ShapeKind::rectangle:
    case ShapeKind::box: return box_axis_distance(g.half_extents, Transform<S>{}, u);
    case ShapeKind::capsule: return g.half_length * norm(Vec3<S>{u.x, u.y, S(0)});
    case ShapeKind::cylinder: {
      // A point r of the rim has the squared distance |r|^2 - (u . r)^2 from the line, where
      //   |u . r - half_length u.z| <= radius |u_xy|.
      const S nearest = real::max(S(0), g.half_length * real::abs(u.z) - g.radius * norm(Vec3<S>{u.x, u.y, S(0)}));
      return real::sqrt(real::max(S(0), g.half_length * g.half_length + g.radius * g.radius - nearest * nearest));
    }
    case ShapeKind::convex:
      for (const Vec3<S>& v : g.hull->vertices) most = real::max(most, norm(cross(u, v)));
      break;
    case ShapeKind::mesh:
    case ShapeKind::compound:
      if (g.mesh)
        for (const Vec3<S>& p : g.mesh->points) most = real::max(most, norm(cross(u, p)));
      for (const auto& part : g.parts)
        most = real::max(most, box_axis_distance(part.half_extents, transform(part.p_B, part.q_BP), u));
      break;
    default: break;
  }
  return most;
}

// Farthest point of the core from the body's origin.
template <class S> S core_radius(const Geometry<S>& g) {
  if (g.kind == ShapeKind::sphere || g.kind == ShapeKind::plane) return S(0);
  return g.kind == ShapeKind::capsule ? g.half_length : g.bounding_radius;
}

// The angular velocity as far as it moves the shape: zero for a sphere, and for a rotation about an axis of symmetry.
template <class S> Vec3<S> effective_spin(const RotatingBody<S>& body) {
  const ShapeKind kind = body.shape.kind;
  if (kind == ShapeKind::sphere || kind == ShapeKind::plane) return {};
  const bool round = kind == ShapeKind::capsule || kind == ShapeKind::cylinder;
  const Vec3<S>&axis = body.pose.axis_W[2], &w = body.w_W;
  return round && norm(cross(w, axis)) <= S(4) * real::epsilon<S>() * norm(w) ? Vec3<S>{} : w;
}

// A convex part of a rotating body: `support(d_W)` is its core's support about the body's origin,
// `support.axis_distance(u_W)` the core's largest distance from an axis through that origin.
template <class S, class Support> struct Part {
  Vec3<S> w_W;
  S radius;
  const Support& support;

  bool rotates(const Vec3<S>& n) const {
    const Vec3<S> turn = cross(n, w_W);
    return radius > S(0) && dot(turn, turn) > S(0);
  }
  S acceleration_bound(const Vec3<S>& n) const { return norm(w_W) * norm(cross(n, w_W)) * radius; }
  // The support of the region swept by a full turn about the axis u: a point r sweeps the circle about (u . r) u whose
  // radius is |u x r|.
  S full_turn_support(const Vec3<S>& n) const {
    if (!rotates(n)) return support(n);
    const Vec3<S> u = (S(1) / norm(w_W)) * w_W;
    const S along = dot(n, u);
    return real::abs(along) * support(along < S(0) ? -u : u) + norm(cross(n, u)) * support.axis_distance(u);
  }
};
template <class S, class Support> Part(Vec3<S>, S, const Support&) -> Part<S, Support>;

// How long a gap that closes at this speed stays above round-off; infinite: until max_s.
template <class S> S time_to_close(S gap, S approach_speed, S max_s, S round_off) {
  if (!(gap > round_off)) return S(0);
  return gap - max_s * approach_speed > round_off ? std::numeric_limits<S>::infinity()
                                                  : (gap - round_off) / approach_speed;
}

// With v that of a relative to b and unit n from a to b, after a time h the parts are at least
//   f(h) = gap - h v.n - [s_a(n + h n x w_a) - s_a(n)] - [s_b(-n - h n x w_b) - s_b(-n)] - h^2/2 (bend_a + bend_b)
// apart along n: a point r goes along n by h n.(w x r) = h (n x w).r and, from there on its circle, by |w| |n x w| |r|
// h^2/2 at most. f is concave, so it is positive on an interval if it is at both ends, and a chord's root is a lower
// bound on its root. A second bound: no rotation takes a part beyond the region swept by its full turn, so
// gap - h v.n less what the full turns add holds for all h.
template <class S, class PartA, class PartB>
S contact_free_time(S gap, const Vec3<S>& n, const Vec3<S>& v_W, const PartA& a, const PartB& b, S max_s, S round_off) {
  const Vec3<S> turn_a = cross(n, a.w_W), turn_b = cross(n, b.w_W);
  const bool rotates_a = a.rotates(n), rotates_b = b.rotates(n);
  const S acceleration_bound =
      (rotates_a ? a.acceleration_bound(n) : S(0)) + (rotates_b ? b.acceleration_bound(n) : S(0));
  const S approach_speed = dot(v_W, n), now_a = rotates_a ? a.support(n) : S(0),
          now_b = rotates_b ? b.support(-n) : S(0);
  const auto f = [&](S h) {
    const S by_a = rotates_a ? a.support(n + h * turn_a) - now_a : S(0);
    const S by_b = rotates_b ? b.support(-(n + h * turn_b)) - now_b : S(0);
    return gap - h * approach_speed - by_a - by_b - S(0.5) * acceleration_bound * h * h;
  };
  constexpr S unbounded = std::numeric_limits<S>::infinity();
  S low = S(0), f_low = gap, high = max_s, f_high = f(max_s);
  if (f_high > round_off) return unbounded;
  if (f_high >= S(0)) return max_s;
  S any_rotation_s = S(0);
  if (rotates_a || rotates_b) {
    const S left = gap - (rotates_a ? a.full_turn_support(n) - now_a : S(0)) -
                   (rotates_b ? b.full_turn_support(-n) - now_b : S(0));
    any_rotation_s = time_to_close(left, approach_speed, max_s, round_off);
    if (any_rotation_s == unbounded) return unbounded;
  }
  constexpr int max_rounds = 100;  // the bound so far is returned after them: shorter, never wrong
  for (int round = 0; round < max_rounds; ++round) {
    const S chord = low + (high - low) * (f_low / (f_low - f_high));
    const S f_chord = f(chord);
    if (!(chord > low) || !(f_chord > S(0))) return real::max(any_rotation_s, real::max(low, chord));
    low = chord, f_low = f_chord;
    if (f_low <= gap / S(8)) break;
    const S twice = S(2) * low;
    if (!(twice < high)) continue;
    if (const S f_twice = f(twice); f_twice > S(0)) low = twice, f_low = f_twice;
    else high = twice, f_high = f_twice;
  }
  return real::max(any_rotation_s, low);
}

template <class S> struct StepSearch {
  const RotatingBody<S>&a, &b;
  Vec3<S> w_a, w_b, v_W;
  S max_s, round_off;
  S approach_speed_bound{};  // no gap of any two parts closes faster
  ConservativeStep<S> result{};

  StepSearch(const RotatingBody<S>& of_a, const RotatingBody<S>& of_b, const Vec3<S>& v, S left_s, S touch)
      : a(of_a), b(of_b), w_a(effective_spin(a)), w_b(effective_spin(b)), v_W(v), max_s(left_s), round_off(touch) {
    approach_speed_bound = norm(v_W) + norm(w_a) * core_radius(a.shape) + norm(w_b) * core_radius(b.shape);
    result.step_s = std::numeric_limits<S>::infinity();
  }
  // Parts farther apart than this cannot lower the bound.
  S relevant_distance() const { return approach_speed_bound * real::min(result.step_s, max_s) + round_off; }

  // `face` is a direction that may separate them for longer than the one between their nearest points (the normal of a
  // floor under a body that rotates close above it); `skins` is the sum of the radii around their cores.
  template <class SupportA, class SupportB>
  void add_pair(S gap, const Vec3<S>& n, const SupportA& of_a, S radius_a, const SupportB& of_b, S radius_b,
                Vec3<S> face = {}, S skins = S(0)) {
    const bool nearest = gap < result.gap;
    result.gap = real::min(result.gap, gap);
    if (gap <= round_off) {
      if (nearest || !result.touching) result.normal_W = n;
      result.touching = true;
      result.step_s = S(0);
      return;
    }
    const Part<S, SupportA> part_a{w_a, radius_a, of_a};
    const Part<S, SupportB> part_b{w_b, radius_b, of_b};
    S until = contact_free_time(gap, n, v_W, part_a, part_b, max_s, round_off);
    if (until < result.step_s && until < max_s && dot(face, face) > S(0)) {
      if (dot(face, n) < S(0)) face = -face;
      const S left =
          dot(face, b.pose.p_W - a.pose.p_W) - part_a.full_turn_support(face) - part_b.full_turn_support(-face) - skins;
      until = real::max(until, time_to_close(left, dot(v_W, face), max_s, round_off));
    }
    if (until < result.step_s) result.step_s = until, result.normal_W = n;
  }
};

// ---- supports of parts about their bodies' origins ----------------------------------------------------------------
template <class S> struct BodySupport {
  const RotatingBody<S>& body;
  S operator()(const Vec3<S>& d_W) const { return core_support(body.shape, to_body(body.pose, d_W)); }
  S axis_distance(const Vec3<S>& u_W) const { return core_axis_distance(body.shape, to_body(body.pose, u_W)); }
};
template <class S> BodySupport<S> support_of(const RotatingBody<S>& body) { return {body}; }

template <class S> struct BoxSupport {
  Vec3<S> half_extents;
  Transform<S> from_origin_W;  // its axes, and its centre from the body's origin
  S operator()(const Vec3<S>& d_W) const {
    return dot(d_W, from_origin_W.p_W) + box_support(half_extents, to_body(from_origin_W, d_W));
  }
  S axis_distance(const Vec3<S>& u_W) const { return box_axis_distance(half_extents, from_origin_W, u_W); }
};

template <class S> struct TriangleSupport {
  const TriangleMesh<S>& mesh;
  int t;
  const Transform<S>& pose;
  const Vec3<S>& corner(int k) const { return mesh.points[mesh.triangles[t].corner[k]]; }
  S operator()(const Vec3<S>& d_W) const {
    const Vec3<S> d = to_body(pose, d_W);
    return real::max(dot(d, corner(0)), real::max(dot(d, corner(1)), dot(d, corner(2))));
  }
  S axis_distance(const Vec3<S>& u_W) const {
    const Vec3<S> u = to_body(pose, u_W);
    return real::max(norm(cross(u, corner(0))), real::max(norm(cross(u, corner(1))), norm(cross(u, corner(2)))));
  }
};
template <class S> TriangleSupport<S> triangle_support(const TriangleMesh<S>& mesh, int t, const Transform<S>& pose) {
  return {mesh, t, pose};
}

// A body's convex parts but those of meshes: itself, or a compound's boxes. visit(shape, transform, support, radius).
template <class S, class Visit> void each_part(const RotatingBody<S>& body, const Visit& visit) {
  if (body.shape.kind != ShapeKind::compound)
    return visit(body.shape, body.pose, support_of(body), core_radius(body.shape));
  for (const auto& part : body.shape.parts) {
    Geometry<S> box;
    box.kind = ShapeKind::box;
    box.half_extents = part.half_extents;
    box.bounding_radius = (S(1) + S(4) * real::epsilon<S>()) * norm(part.half_extents);
    const Transform<S> pose = part_transform(body.pose, part);
    BoxSupport<S> support{part.half_extents, pose};
    support.from_origin_W.p_W = to_world(body.pose, part.p_B);
    visit(box, pose, support, norm(part.p_B) + box.bounding_radius);
  }
}

template <class S> void bound_by_convex_parts(StepSearch<S>& search) {
  each_part(search.a, [&](const Geometry<S>& of_a, const Transform<S>& pose_a, const auto& support_a, S radius_a) {
    each_part(search.b, [&](const Geometry<S>& of_b, const Transform<S>& pose_b, const auto& support_b, S radius_b) {
      if (norm(pose_b.p_W - pose_a.p_W) - of_a.bounding_radius - of_b.bounding_radius > search.relevant_distance())
        return;
      const Separation<S> s = separation(of_a, pose_a, of_b, pose_b);
      search.add_pair(s.gap, s.normal_W, support_a, radius_a, support_b, radius_b);
    });
  });
}

// `mesh_is_a`: the mesh is body a, else body b.
template <class S> void bound_by_triangles(StepSearch<S>& search, bool mesh_is_a) {
  const RotatingBody<S>&solid = mesh_is_a ? search.a : search.b, &other = mesh_is_a ? search.b : search.a;
  const TriangleMesh<S>& mesh = *solid.shape.mesh;
  each_part(other, [&](const Geometry<S>& shape, const Transform<S>& pose, const auto& support, S radius) {
    ConvexPart<S> part;
    if (!convex_part(shape, part)) return;
    const Transform<S> in_mesh = relative_transform(solid.pose, pose);
    nearest_triangles(mesh, bounds_of(part, in_mesh), search.relevant_distance(), [&](int t) {
      const NearestFeatures<S> features =
          nearest_features(part_of(mesh, t), part, in_mesh, search.relevant_distance() + part.radius);
      if (features.out_of_range) return search.relevant_distance();
      const Vec3<S> n = to_world(solid.pose, features.normal);
      const auto of_triangle = triangle_support(mesh, t, solid.pose);
      const S gap = features.gap - part.radius;
      const Vec3<S> face = to_world(solid.pose, mesh.triangles[t].normal);
      if (mesh_is_a)
        search.add_pair(gap, n, of_triangle, solid.shape.bounding_radius, support, radius, face, part.radius);
      else search.add_pair(gap, -n, support, radius, of_triangle, solid.shape.bounding_radius, face, part.radius);
      return search.relevant_distance();
    });
  });
}

template <class S> void bound_by_triangle_pairs(StepSearch<S>& search) {
  const TriangleMesh<S>&a = *search.a.shape.mesh, &b = *search.b.shape.mesh;
  const Transform<S> b_in_a = relative_transform(search.a.pose, search.b.pose);
  const auto should_descend = [&](const Aabb<S>& of_a, const Aabb<S>& of_b) {
    return distance_between(of_a, of_b) <= search.relevant_distance();
  };
  each_pair_of_triangles(a, b, b_in_a, should_descend, [&](int t, int u) {
    const NearestFeatures<S> features =
        nearest_features(part_of(a, t), placed_part(b, u, b_in_a), Transform<S>{}, search.relevant_distance());
    if (features.out_of_range) return;
    const auto of_a = triangle_support(a, t, search.a.pose), of_b = triangle_support(b, u, search.b.pose);
    const bool still_a = !(dot(search.w_a, search.w_a) > S(0));  // a body at rest gives the more useful direction
    const Vec3<S> face =
        still_a ? to_world(search.a.pose, a.triangles[t].normal) : to_world(search.b.pose, b.triangles[u].normal);
    search.add_pair(features.gap, to_world(search.a.pose, features.normal), of_a, search.a.shape.bounding_radius, of_b,
                    search.b.shape.bounding_radius, face);
  });
}

}  // namespace

template <class S>
ConservativeStep<S> conservative_step(const RotatingBody<S>& a, const RotatingBody<S>& b, const Vec3<S>& v_W, S max_s,
                                      S round_off) {
  StepSearch<S> search(a, b, v_W, max_s, round_off);
  const auto is = [](const RotatingBody<S>& body, ShapeKind kind) { return body.shape.kind == kind; };
  const auto is_empty = [&](const RotatingBody<S>& body) {
    return (is(body, ShapeKind::mesh) && (!body.shape.mesh || body.shape.mesh->nodes.empty())) ||
           (is(body, ShapeKind::convex) && (!body.shape.hull || body.shape.hull->vertices.empty()));
  };
  if (is_empty(a) || is_empty(b)) return search.result;
  if (is(a, ShapeKind::plane) || is(b, ShapeKind::plane)) {  // a plane has one normal for all parts
    const Separation<S> s = separation(a.shape, a.pose, b.shape, b.pose);
    search.add_pair(s.gap, s.normal_W, support_of(a), core_radius(a.shape), support_of(b), core_radius(b.shape));
  } else if (is(a, ShapeKind::mesh) && is(b, ShapeKind::mesh)) {
    bound_by_triangle_pairs(search);
  } else if (is(a, ShapeKind::mesh) || is(b, ShapeKind::mesh)) {
    bound_by_triangles(search, is(a, ShapeKind::mesh));
  } else {
    bound_by_convex_parts(search);
  }
  return search.result;
}

#define ATWOOD_CONSERVATIVE_STEP(S)                                                                                    \
  template ConservativeStep<S> conservative_step<S>(const RotatingBody<S>&, const RotatingBody<S>&, const Vec3<S>&, S, \
                                                    S);
ATWOOD_CONSERVATIVE_STEP(float)
ATWOOD_CONSERVATIVE_STEP(double)
ATWOOD_CONSERVATIVE_STEP(long double)
#undef ATWOOD_CONSERVATIVE_STEP

}  // namespace atwood
