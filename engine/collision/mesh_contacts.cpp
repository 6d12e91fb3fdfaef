// Contacts and closest features of a triangle mesh with the other shapes: with a plane by the mesh's points, with the
// others by its triangles. A mesh that bounds a convex solid is treated as a hull (convex_contacts.hpp).
#include <limits>
#include <utility>

#include "collision/convex_contacts.hpp"
#include "collision/mesh_queries.hpp"

namespace atwood {
namespace {

template <class S> void express_in_world(const Transform<S>& pose, std::vector<Manifold<S>>& out, std::size_t from) {
  for (std::size_t i = from; i < out.size(); ++i) {
    out[i].normal_W = to_world(pose, out[i].normal_W);
    for (int k = 0; k < out[i].count; ++k) out[i].points[k].x_W = point_to_world(pose, out[i].points[k].x_W);
  }
}

// Against a plane a mesh has the contacts of its convex hull. Heights are computed in the mesh's axes, relative to its
// centre (as in hull_plane_contacts()).
template <class S>
void mesh_plane_contacts(const TriangleMesh<S>& mesh, const Transform<S>& pose, const Geometry<S>& plane, S margin,
                         std::vector<Manifold<S>>& out) {
  static thread_local std::vector<ContactPoint<S>> found;
  found.clear();
  const Vec3<S> n = to_body(pose, plane.normal_W);
  const S plane_offset = plane.offset - dot(plane.normal_W, pose.p_W);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const S gap = dot(n, mesh.points[i]) - plane_offset;
    if (gap <= margin)
      found.push_back({point_to_world(pose, mesh.points[i]) - (gap / S(2)) * plane.normal_W, gap,
                       static_cast<std::uint32_t>(i + 1)});
  }
  if (found.empty()) return;
  Manifold<S> manifold;
  manifold.normal_W = -plane.normal_W;
  keep_four(found, plane.normal_W, manifold);
  out.push_back(manifold);
}

template <class S>
Separation<S> mesh_plane_separation(const TriangleMesh<S>& mesh, const Transform<S>& pose, const Geometry<S>& plane) {
  const Vec3<S> n = to_body(pose, plane.normal_W);
  const S plane_offset = plane.offset - dot(plane.normal_W, pose.p_W);
  Separation<S> least{std::numeric_limits<S>::infinity(), -plane.normal_W, pose.p_W, pose.p_W};
  for (const Vec3<S>& p : mesh.points)
    if (const S gap = dot(n, p) - plane_offset; gap < least.gap)
      least.gap = gap, least.on_a_W = point_to_world(pose, p);
  least.on_b_W = least.on_a_W + least.gap * least.normal_W;
  return least;
}

// The deepest point of all manifolds; false if there is none.
template <class S> bool deepest(const std::vector<Manifold<S>>& manifolds, Separation<S>& separation) {
  bool any = false;
  for (const Manifold<S>& m : manifolds)
    for (int i = 0; i < m.count; ++i) {
      const ContactPoint<S>& p = m.points[i];
      if (any && !(p.gap < separation.gap)) continue;
      separation = {p.gap, m.normal_W, p.x_W - (p.gap / S(2)) * m.normal_W, p.x_W + (p.gap / S(2)) * m.normal_W,
                    m.solve};
      any = true;
    }
  return any;
}

template <class S>
Separation<S> nearest_triangle(const TriangleMesh<S>& mesh, const ConvexPart<S>& b, const Transform<S>& b_in_mesh) {
  Separation<S> nearest{std::numeric_limits<S>::infinity(), {S(0), S(0), S(1)}, {}, b_in_mesh.p_W};
  nearest_triangles(mesh, bounds_of(b, b_in_mesh), nearest.gap, [&](int t) {
    const NearestFeatures<S> features =
        nearest_features(part_of(mesh, t), b, b_in_mesh, real::max(nearest.gap, S(0)) + b.radius);
    if (!features.out_of_range && features.gap - b.radius < nearest.gap)
      nearest = {features.gap - b.radius, features.normal, features.on_a, features.on_b - b.radius * features.normal,
                 features.solve};
    return nearest.gap;
  });
  return nearest;
}

template <class S> Separation<S> nearest_point(const TriangleMesh<S>& mesh, const Vec3<S>& center, S radius) {
  const MeshPoint<S> near = closest_on_mesh(mesh, center);
  const Vec3<S> away = unit_vector(near.inside ? near.at.x - center : center - near.at.x);
  const Vec3<S> normal = dot(away, away) > S(0) ? away : mesh.triangles[near.triangle].normal;
  return {near.inside ? -near.at.distance - radius : near.at.distance - radius, normal, near.at.x,
          center - radius * normal};
}

}  // namespace

template <class S>
void mesh_contacts(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b, const Transform<S>& pose_b,
                   S margin, std::vector<Manifold<S>>& out) {
  if (!a.mesh) return;
  if (b.kind == ShapeKind::plane) return mesh_plane_contacts(*a.mesh, pose_a, b, margin, out);
  const std::size_t from = out.size();
  ConvexPart<S> of_a, of_b;
  const bool convex_a = convex_part(a, of_a), convex_b = convex_part(b, of_b);
  if (convex_a && convex_b) return convex_contacts(a, pose_a, b, pose_b, margin, out);
  if (convex_a) {  // by the triangles of the other mesh
    mesh_contacts(b, pose_b, a, pose_a, margin, out);
    for (std::size_t i = from; i < out.size(); ++i) {
      out[i].normal_W = -out[i].normal_W;
      std::swap(out[i].part_a, out[i].part_b);
    }
    return;
  }
  const Transform<S> b_in_a = relative_transform(pose_a, pose_b);
  if (b.kind == ShapeKind::sphere) mesh_sphere_contacts(*a.mesh, b_in_a.p_W, b.radius, margin, out);
  else if (convex_b) mesh_convex_contacts(*a.mesh, of_b, b_in_a, margin, out);
  else if (b.kind == ShapeKind::mesh && b.mesh) mesh_mesh_contacts(*a.mesh, *b.mesh, b_in_a, margin, out);
  express_in_world(pose_a, out, from);
}

template <class S>
Separation<S> mesh_separation(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b,
                              const Transform<S>& pose_b) {
  static thread_local std::vector<Manifold<S>> overlapping;
  Separation<S> nearest{std::numeric_limits<S>::infinity(), {S(0), S(0), S(1)}, pose_a.p_W, pose_b.p_W};
  if (!a.mesh || a.mesh->nodes.empty()) return nearest;
  if (b.kind == ShapeKind::plane) return mesh_plane_separation(*a.mesh, pose_a, b);
  ConvexPart<S> of_a, of_b;
  const bool convex_a = convex_part(a, of_a), convex_b = convex_part(b, of_b);
  if (convex_a && convex_b) return convex_separation(a, pose_a, b, pose_b);
  if (convex_a) {
    const Separation<S> other = mesh_separation(b, pose_b, a, pose_a);
    return {other.gap, -other.normal_W, other.on_b_W, other.on_a_W, other.solve};
  }
  const Transform<S> b_in_a = relative_transform(pose_a, pose_b);
  if (b.kind == ShapeKind::sphere) nearest = nearest_point(*a.mesh, b_in_a.p_W, b.radius);
  else if (convex_b) nearest = nearest_triangle(*a.mesh, of_b, b_in_a);
  else if (b.kind == ShapeKind::mesh && b.mesh) nearest = mesh_mesh_separation(*a.mesh, *b.mesh, b_in_a);
  else return nearest;
  nearest.normal_W = to_world(pose_a, nearest.normal_W);
  nearest.on_a_W = point_to_world(pose_a, nearest.on_a_W), nearest.on_b_W = point_to_world(pose_a, nearest.on_b_W);
  const bool closed = a.mesh->closed || (b.mesh && b.mesh->closed);
  if (b.kind == ShapeKind::sphere || (nearest.gap > S(0) && !closed)) return nearest;
  overlapping.clear();
  mesh_contacts(a, pose_a, b, pose_b, S(0), overlapping);
  deepest(overlapping, nearest);
  return nearest;
}

#define ATWOOD_MESH_CONTACTS(S)                                                                                       \
  template void mesh_contacts<S>(const Geometry<S>&, const Transform<S>&, const Geometry<S>&, const Transform<S>&, S, \
                                 std::vector<Manifold<S>>&);                                                          \
  template Separation<S> mesh_separation<S>(const Geometry<S>&, const Transform<S>&, const Geometry<S>&,              \
                                            const Transform<S>&);
ATWOOD_MESH_CONTACTS(float)
ATWOOD_MESH_CONTACTS(double)
ATWOOD_MESH_CONTACTS(long double)
#undef ATWOOD_MESH_CONTACTS

}  // namespace atwood
