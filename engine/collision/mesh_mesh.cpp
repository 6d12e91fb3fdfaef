// Two meshes: pairs of triangles whose boxes overlap; whether they intersect is decided exactly (predicates.hpp).
#include <limits>
#include <utility>
#include <vector>

#include "collision/mesh_queries.hpp"
#include "collision/predicates.hpp"

namespace atwood {
namespace {

template <class S> Corners<S> corners_of(const ConvexPart<S>& triangle) {
  return {triangle.own[0], triangle.own[1], triangle.own[2]};
}

// Triangle t of mesh A and triangle u of mesh B.
template <class S> struct TrianglePair {
  const TriangleMesh<S>&a, &b;
  const Transform<S>& b_in_a;
  int t, u;
  ConvexPart<S> part_t, part_u;  // both in A's axes
};

// The contact points of a pair whose normal of least overlap belongs to neither triangle's Voronoi regions: along the
// normal of one of the two faces. The face with the smaller depth is tried first. A face is skipped if the overlap
// along the normal of one of its neighbours is smaller (neighbour_is_shallower): the pair with that neighbour has the
// contact. manifold.count is 0 if both faces are skipped. `depths_a`, `depths_b`: depths of the contacts found by
// regions.
template <class S>
void face_contact(const TrianglePair<S>& of, const TriangleDepths<S>& depths_a, const TriangleDepths<S>& depths_b,
                  S margin, S round_off, Manifold<S>& manifold) {
  const Transform<S> same;
  const ConvexPart<S>&t = of.part_t, &u = of.part_u;
  const Vec3<S> normals[2] = {t.triangle_faces[0].normal, -u.triangle_faces[0].normal};
  const S depths[2] = {overlap_along(t, u, same, normals[0]), overlap_along(t, u, same, normals[1])};
  const auto depth_along_a = [&](int s) {
    return depths_a.least(s, overlap_along(part_of(of.a, s), u, same, of.a.triangles[s].normal));
  };
  const auto depth_along_b = [&](int s) {
    const ConvexPart<S> part = placed_part(of.b, s, of.b_in_a);
    return depths_b.least(s, overlap_along(t, part, same, -part.triangle_faces[0].normal));
  };
  const bool u_is_shallower = depths[1] < depths[0];
  for (const bool of_u : {u_is_shallower, !u_is_shallower}) {
    const S depth = depths[of_u] - round_off;
    if (depth > S(0) && (of_u ? neighbour_is_shallower(of.b, of.u, S(1), depth, depth_along_b)
                              : neighbour_is_shallower(of.a, of.t, S(1), depth, depth_along_a)))
      continue;
    const NearestFeatures<S> features{false, std::numeric_limits<S>::infinity(), normals[of_u], {}, {}};
    contact_points(t, u, same, features, margin, manifold);
    if (manifold.count > 0) return;
  }
}

// Whether `inner` lies inside the closed `mesh`, for meshes whose surfaces do not intersect: then all of its points lie
// on the same side, and one is tested.
template <class S>
bool is_enclosed(const TriangleMesh<S>& mesh, const TriangleMesh<S>& inner, const Transform<S>& pose) {
  if (!mesh.closed || mesh.nodes.empty() || inner.points.empty()) return false;
  const Vec3<S> x = point_to_world(pose, inner.points[0]);
  return overlap(mesh.nodes[0].box, Aabb<S>{x, x}) && closest_on_mesh(mesh, x).inside;
}

// The contact of a mesh that lies inside another one.
template <class S>
Manifold<S> enclosed_mesh_manifold(const TriangleMesh<S>& mesh, const TriangleMesh<S>& inner,
                                   const Transform<S>& pose) {
  return enclosed_manifold(mesh, closest_on_mesh(mesh, pose.p_W), pose.p_W, [&](const Vec3<S>& n) {
    const Vec3<S> d = to_body(pose, n);
    const Vec3<S>* lowest = &inner.points[0];
    for (const Vec3<S>& p : inner.points)
      if (dot(d, p) < dot(d, *lowest)) lowest = &p;
    return point_to_world(pose, *lowest);
  });
}

}  // namespace

template <class S>
void mesh_mesh_contacts(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Transform<S>& b_in_a, S margin,
                        std::vector<Manifold<S>>& out) {
  if (a.nodes.empty() || b.nodes.empty()) return;
  const auto should_descend = [&](const Aabb<S>& of_a, const Aabb<S>& of_b) {
    return overlap(of_a, grown(of_b, margin));
  };
  const Transform<S> same;
  const std::size_t from = out.size();
  const S round_off = S(64) * real::epsilon<S>() * (a.bounding_radius + b.bounding_radius + norm(b_in_a.p_W));
  int closest_t = -1, closest_u = -1;  // the nearest triangles: their contact is taken if every face is skipped
  NearestFeatures<S> closest_features;
  static thread_local std::vector<TrianglePair<S>> without_region;
  static thread_local TriangleDepths<S> depths_a, depths_b;
  without_region.clear(), depths_a.clear(), depths_b.clear();
  const auto add = [&](int t, int u, Manifold<S>& manifold) {
    if (manifold.count == 0) return;
    manifold.part_a = a.scene_index[t], manifold.part_b = b.scene_index[u];
    out.push_back(manifold);
  };
  each_pair_of_triangles(a, b, b_in_a, should_descend, [&](int t, int u) {
    const ConvexPart<S> part_t = part_of(a, t), part_u = placed_part(b, u, b_in_a);
    if (!overlap(bounds_of(part_t, same), grown(bounds_of(part_u, same), margin))) return;
    const bool hit = triangles_intersect(corners_of(part_t), corners_of(part_u));
    if (!hit && !(margin > S(0))) return;
    NearestFeatures<S> features =
        nearest_features(part_t, part_u, same, hit ? std::numeric_limits<S>::infinity() : margin);
    if (!hit && (features.out_of_range || features.gap > margin)) return;
    if (closest_t < 0 || features.gap < closest_features.gap) closest_t = t, closest_u = u, closest_features = features;
    Vec3<S> normal_of_b = to_body(b_in_a, -features.normal);
    if (!normal_in_region(a, t, features.normal) || !normal_in_region(b, u, normal_of_b)) {
      without_region.push_back({a, b, b_in_a, t, u, part_t, part_u});
      return;
    }
    depths_a.add(t, -features.gap);
    depths_b.add(u, -features.gap);
    Manifold<S> manifold;
    contact_points(part_t, part_u, same, features, margin, manifold);
    add(t, u, manifold);
  });
  for (const TrianglePair<S>& pair : without_region) {
    Manifold<S> manifold;
    face_contact(pair, depths_a, depths_b, margin, round_off, manifold);
    add(pair.t, pair.u, manifold);
  }
  if (out.size() > from) return;
  Transform<S> a_in_b;
  for (int k = 0; k < 3; ++k) {
    const Vec3<S>* axis = b_in_a.axis_W;
    a_in_b.axis_W[k] = k == 0   ? Vec3<S>{axis[0].x, axis[1].x, axis[2].x}
                       : k == 1 ? Vec3<S>{axis[0].y, axis[1].y, axis[2].y}
                                : Vec3<S>{axis[0].z, axis[1].z, axis[2].z};
  }
  a_in_b.p_W = -to_body(b_in_a, b_in_a.p_W);
  if (is_enclosed(a, b, b_in_a)) {
    out.push_back(enclosed_mesh_manifold(a, b, b_in_a));
  } else if (is_enclosed(b, a, a_in_b)) {
    Manifold<S> manifold = enclosed_mesh_manifold(b, a, a_in_b);
    manifold.normal_W = to_world(b_in_a, -manifold.normal_W);
    manifold.points[0].x_W = point_to_world(b_in_a, manifold.points[0].x_W);
    std::swap(manifold.part_a, manifold.part_b);
    out.push_back(manifold);
  } else if (closest_t >= 0) {
    Manifold<S> manifold;
    contact_points(part_of(a, closest_t), placed_part(b, closest_u, b_in_a), same, closest_features, margin, manifold);
    add(closest_t, closest_u, manifold);
  }
}

template <class S>
Separation<S> mesh_mesh_separation(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Transform<S>& b_in_a) {
  Separation<S> nearest{std::numeric_limits<S>::infinity(), {S(0), S(0), S(1)}, {}, b_in_a.p_W};
  if (a.nodes.empty() || b.nodes.empty()) return nearest;
  const auto should_descend = [&](const Aabb<S>& of_a, const Aabb<S>& of_b) {
    return distance_between(of_a, of_b) < nearest.gap;
  };
  each_pair_of_triangles(a, b, b_in_a, should_descend, [&](int t, int u) {
    const NearestFeatures<S> features =
        nearest_features(part_of(a, t), placed_part(b, u, b_in_a), Transform<S>{}, real::max(nearest.gap, S(0)));
    if (!features.out_of_range && features.gap < nearest.gap)
      nearest = {features.gap, features.normal, features.on_a, features.on_b};
  });
  return nearest;
}

#define ATWOOD_MESH_MESH(S)                                                                                   \
  template void mesh_mesh_contacts<S>(const TriangleMesh<S>&, const TriangleMesh<S>&, const Transform<S>&, S, \
                                      std::vector<Manifold<S>>&);                                             \
  template Separation<S> mesh_mesh_separation<S>(const TriangleMesh<S>&, const TriangleMesh<S>&, const Transform<S>&);
ATWOOD_MESH_MESH(float)
ATWOOD_MESH_MESH(double)
ATWOOD_MESH_MESH(long double)
#undef ATWOOD_MESH_MESH

}  // namespace atwood
