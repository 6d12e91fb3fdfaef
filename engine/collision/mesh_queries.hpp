// Queries on triangle meshes: traversals of the tree, closest points on triangles, and the normals that belong to a
// triangle's Voronoi regions.
#pragma once

#include <utility>
#include <vector>

#include "collision/convex_manifold.hpp"
#include "collision/triangle_mesh.hpp"

namespace atwood {

template <class S> inline bool overlap(const Aabb<S>& a, const Aabb<S>& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
         a.low.z <= b.high.z && b.low.z <= a.high.z;
}
template <class S> inline Aabb<S> grown(const Aabb<S>& box, S by) {
  return {box.low - Vec3<S>{by, by, by}, box.high + Vec3<S>{by, by, by}};
}
// Distance of two boxes; a point is a box without size.
template <class S> inline S distance_between(const Aabb<S>& a, const Aabb<S>& b) {
  const auto apart = [](S low, S high, S other_low, S other_high) {
    return real::max(S(0), real::max(low - other_high, other_low - high));
  };
  return norm(Vec3<S>{apart(a.low.x, a.high.x, b.low.x, b.high.x), apart(a.low.y, a.high.y, b.low.y, b.high.y),
                      apart(a.low.z, a.high.z, b.low.z, b.high.z)});
}

// Calls visit(t) for every triangle in a leaf whose box meets `box`.
template <class S, class Visit>
void each_triangle(const TriangleMesh<S>& mesh, const Aabb<S>& box, const Visit& visit) {
  if (mesh.nodes.empty()) return;
  int stack[64] = {0}, height = 1;
  while (height > 0) {
    const int n = stack[--height];
    const auto& node = mesh.nodes[n];
    if (!overlap(node.box, box)) continue;
    for (int t = node.first; node.right < 0 && t < node.first + node.count; ++t) visit(t);
    if (node.right >= 0) stack[height++] = node.right, stack[height++] = n + 1;
  }
}

// Calls `least = visit(t)`, nearer halves first, for every triangle whose box lies nearer to `box` than `least`.
template <class S, class Visit>
void nearest_triangles(const TriangleMesh<S>& mesh, const Aabb<S>& box, S least, const Visit& visit) {
  if (mesh.nodes.empty()) return;
  struct Pending {
    int node;
    S distance;
  } stack[64];
  int height = 1;
  stack[0] = {0, distance_between(mesh.nodes[0].box, box)};
  while (height > 0) {
    const Pending top = stack[--height];
    if (top.distance > least) continue;
    const auto& node = mesh.nodes[top.node];
    for (int t = node.first; node.right < 0 && t < node.first + node.count; ++t) least = real::min(least, visit(t));
    if (node.right < 0) continue;
    Pending near{top.node + 1, distance_between(mesh.nodes[top.node + 1].box, box)};
    Pending far{node.right, distance_between(mesh.nodes[node.right].box, box)};
    if (far.distance < near.distance) std::swap(near, far);
    stack[height++] = far, stack[height++] = near;
  }
}

template <class S> struct TrianglePoint {
  enum Part : unsigned char { face, edge, corner } part = face;
  int which = 0;  // edge or corner of the triangle
  Vec3<S> x;
  S distance{};
};
// A point within `tolerance` of an edge or corner counts as on it.
template <class S>
TrianglePoint<S> closest_on_triangle(const TriangleMesh<S>& mesh, int t, const Vec3<S>& c, S tolerance);

// Whether the point at.x + out lies in the Voronoi region of the feature `at` of triangle t, up to `tolerance` [m].
template <class S>
bool in_voronoi_region(const TriangleMesh<S>& mesh, int t, const TrianglePoint<S>& at, const Vec3<S>& out, S tolerance);
// The angle-weighted pseudonormal at that feature (Baerentzen, Aanaes 2005): it points out of a closed mesh.
template <class S> Vec3<S> pseudonormal(const TriangleMesh<S>& mesh, int t, const TrianglePoint<S>& at);

// Whether the normal n lies in a Voronoi region of triangle t (of its face, an edge or a corner). False if it lies in a
// neighbour's region or points into a closed mesh. An n that equals the face's normal up to round-off is set to it.
template <class S> bool normal_in_region(const TriangleMesh<S>& mesh, int t, Vec3<S>& n);

// Whether a neighbour of triangle t has a depth below `depth`. Neighbours are the triangles around t's three corners,
// as far as they are reached across edges that are not concave. A body that overlaps both faces of a convex edge has a
// contact with the face of smaller depth only; along a concave edge both faces have contacts. `side`: +1 for a body in
// front of the surface; -1 behind, where convex edges are concave and the reverse. depth_along(s): the depth of the
// overlap along the normal of triangle s.
template <class S, class DepthAlong>
bool neighbour_is_shallower(const TriangleMesh<S>& mesh, int t, S side, S depth, const DepthAlong& depth_along) {
  const EdgeKind concave = side > S(0) ? EdgeKind::concave : EdgeKind::convex;
  for (int k = 0; k < 3; ++k) {
    const int pivot = mesh.triangles[t].corner[k];
    for (const bool by_next : {false, true}) {  // around the corner in both directions
      for (int at = t;;) {
        const auto& triangle = mesh.triangles[at];
        const int c = triangle.corner[0] == pivot   ? 0
                      : triangle.corner[1] == pivot ? 1
                                                    : 2,
                  edge = by_next ? c : (c + 2) % 3;
        const int next = triangle.across[edge];
        if (next < 0 || next == t || triangle.edge[edge] == concave) break;
        if (depth_along(next) < depth) return true;
        at = next;
      }
    }
  }
  return false;
}

// Depths of the contacts whose normals lie in a Voronoi region of their triangle. A triangle may have several.
template <class S> class TriangleDepths {
 public:
  void clear() { depths_.clear(); }
  void add(int t, S depth) { depths_.push_back({t, depth}); }
  // The least depth of triangle t, and `otherwise` if that is smaller.
  S least(int t, S otherwise) const {
    for (const auto& [triangle, depth] : depths_)
      if (triangle == t) otherwise = real::min(otherwise, depth);
    return otherwise;
  }

 private:
  std::vector<std::pair<int, S>> depths_;
};

template <class S> struct MeshPoint {
  int triangle = -1;
  TrianglePoint<S> at;
  bool inside = false;  // of a closed mesh
};
template <class S> MeshPoint<S> closest_on_mesh(const TriangleMesh<S>& mesh, const Vec3<S>& c);

// The contact of a body inside a closed mesh. Its normal is, for a convex mesh, that of the face with the least depth
// of penetration; for one that is not convex, that of the surface point `nearest` to the body's `center`. lowest(n):
// the body's support point along -n. One point, halfway between the body's support point and the surface.
template <class S, class Lowest>
Manifold<S> enclosed_manifold(const TriangleMesh<S>& mesh, const MeshPoint<S>& nearest, const Vec3<S>& center,
                              const Lowest& lowest) {
  int t = nearest.triangle;
  const Vec3<S> back = unit_vector(nearest.at.x - center);
  const bool slanted = nearest.at.part != TrianglePoint<S>::face && dot(back, back) > S(0);
  Vec3<S> normal = slanted ? back : mesh.triangles[t].normal;
  const auto depth_along = [&](const Vec3<S>& n, const Vec3<S>& on_face) { return dot(n, on_face - lowest(n)); };
  S depth = depth_along(normal, nearest.at.x);
  if (mesh.convex) {
    for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
      const Vec3<S>& n = mesh.triangles[i].normal;
      const S here = depth_along(n, mesh.points[mesh.triangles[i].corner[0]]);
      if (here < depth) depth = here, normal = n, t = i;
    }
  }
  Manifold<S> manifold;
  manifold.normal_W = normal;
  manifold.count = 1;
  manifold.points[0] = {lowest(normal) + (depth / S(2)) * normal, -depth, 1};
  manifold.part_a = mesh.scene_index[t];
  return manifold;
}

template <class S> ConvexPart<S> part_of(const TriangleMesh<S>& mesh, int t) {
  const auto& triangle = mesh.triangles[t];
  return triangle_part(mesh.points[triangle.corner[0]], mesh.points[triangle.corner[1]],
                       mesh.points[triangle.corner[2]], triangle.normal);
}
template <class S> Aabb<S> bounds_of(const ConvexPart<S>& part, const Transform<S>& pose);

// ---- two meshes, b placed in a's axes -----------------------------------------------------------------------------
// The smallest box in A's axes that contains a box in B's axes, enlarged by round-off.
template <class S> Aabb<S> rotated_box(const Aabb<S>& box, const Transform<S>& b_in_a) {
  const Vec3<S> center = point_to_world(b_in_a, S(0.5) * (box.low + box.high)), h = S(0.5) * (box.high - box.low);
  const Vec3<S>* axis = b_in_a.axis_W;
  const auto extent = [&](S x, S y, S z) { return real::abs(x) * h.x + real::abs(y) * h.y + real::abs(z) * h.z; };
  const Vec3<S> r{extent(axis[0].x, axis[1].x, axis[2].x), extent(axis[0].y, axis[1].y, axis[2].y),
                  extent(axis[0].z, axis[1].z, axis[2].z)};
  return grown(Aabb<S>{center - r, center + r}, S(16) * real::epsilon<S>() * (norm(center) + norm(r)));
}

// Traverses both trees at once.
template <class S> struct TreePairTraversal {
  const TriangleMesh<S>&a, &b;
  const Transform<S>& b_in_a;

  template <class Wanted, class Visit>
  void descend(int m, int n, const Wanted& should_descend, const Visit& visit) const {
    const auto &of_a = a.nodes[m], &of_b = b.nodes[n];
    if (!should_descend(of_a.box, rotated_box(of_b.box, b_in_a))) return;
    if (of_a.right < 0 && of_b.right < 0) {
      for (int t = of_a.first; t < of_a.first + of_a.count; ++t)
        for (int u = of_b.first; u < of_b.first + of_b.count; ++u) visit(t, u);
    } else if (of_b.right < 0 ||
               (of_a.right >= 0 && norm(of_a.box.high - of_a.box.low) >= norm(of_b.box.high - of_b.box.low))) {
      descend(m + 1, n, should_descend, visit);
      descend(of_a.right, n, should_descend, visit);
    } else {
      descend(m, n + 1, should_descend, visit);
      descend(m, of_b.right, should_descend, visit);
    }
  }
};

template <class S> ConvexPart<S> placed_part(const TriangleMesh<S>& mesh, int t, const Transform<S>& pose) {
  const auto& triangle = mesh.triangles[t];
  return triangle_part(point_to_world(pose, mesh.points[triangle.corner[0]]),
                       point_to_world(pose, mesh.points[triangle.corner[1]]),
                       point_to_world(pose, mesh.points[triangle.corner[2]]), to_world(pose, triangle.normal));
}

// Calls visit(t, u) for the triangles in leaves that are reached while should_descend(box of a, box of b in A's axes)
// holds.
template <class S, class Wanted, class Visit>
void each_pair_of_triangles(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Transform<S>& b_in_a,
                            const Wanted& should_descend, const Visit& visit) {
  if (!a.nodes.empty() && !b.nodes.empty()) TreePairTraversal<S>{a, b, b_in_a}.descend(0, 0, should_descend, visit);
}

// ---- one mesh (in its own axes) against one shape placed in those axes; manifolds in mesh axes --------------------
template <class S>
void mesh_sphere_contacts(const TriangleMesh<S>& mesh, const Vec3<S>& center, S radius, S margin,
                          std::vector<Manifold<S>>& out);
template <class S>
void mesh_convex_contacts(const TriangleMesh<S>& mesh, const ConvexPart<S>& b, const Transform<S>& b_in_mesh, S margin,
                          std::vector<Manifold<S>>& out);
template <class S>
void mesh_mesh_contacts(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Transform<S>& b_in_a, S margin,
                        std::vector<Manifold<S>>& out);
template <class S>
Separation<S> mesh_mesh_separation(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Transform<S>& b_in_a);

}  // namespace atwood
