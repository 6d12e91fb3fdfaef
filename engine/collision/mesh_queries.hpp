// What the tests of meshes share: walks over the tree, closest points of triangles, and which normals a triangle may have.
#pragma once

#include <utility>

#include "collision/convex_manifold.hpp"
#include "collision/triangle_mesh.hpp"

namespace atwood {

template <class S> inline bool overlap(const Aabb<S>& a, const Aabb<S>& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y && a.low.z <= b.high.z &&
         b.low.z <= a.high.z;
}
template <class S> inline Aabb<S> grown(const Aabb<S>& box, S by) {
  return {box.low - Vec3<S>{by, by, by}, box.high + Vec3<S>{by, by, by}};
}
// Of two boxes, a point being one without size.
template <class S> inline S distance_between(const Aabb<S>& a, const Aabb<S>& b) {
  const auto apart = [](S low, S high, S other_low, S other_high) {
    return real::max(S(0), real::max(low - other_high, other_low - high));
  };
  return norm(Vec3<S>{apart(a.low.x, a.high.x, b.low.x, b.high.x), apart(a.low.y, a.high.y, b.low.y, b.high.y),
                      apart(a.low.z, a.high.z, b.low.z, b.high.z)});
}

// Calls visit(t) for every triangle in a leaf whose box meets `box`.
template <class S, class Visit> void each_triangle(const TriangleMesh<S>& mesh, const Aabb<S>& box, const Visit& visit) {
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
  struct Pending { int node; S distance; } stack[64];
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

template <class S> struct OnTriangle {
  enum Part : unsigned char { face, edge, corner } part = face;
  int which = 0;     // edge or corner of the triangle
  Vec3<S> x;
  S distance{};
};
// Within `tolerance` of an edge or corner the point counts as there.
template <class S> OnTriangle<S> closest_on_triangle(const TriangleMesh<S>& mesh, int t, const Vec3<S>& c, S tolerance);

// Whether no neighbouring triangle is nearer to x + out than `at` is, up to `tolerance` (of the same length as `out`).
template <class S> bool in_region(const TriangleMesh<S>& mesh, int t, const OnTriangle<S>& at, const Vec3<S>& out, S tolerance);
// A vector that looks out of a closed mesh at that feature.
template <class S> Vec3<S> outwards(const TriangleMesh<S>& mesh, int t, const OnTriangle<S>& at);

// The feature of triangle t that a normal n belongs to; n is set to the face's where it is that up to round-off of angles.
// False when the normal is a neighbour's business, or points into a closed mesh.
template <class S> bool normal_allowed(const TriangleMesh<S>& mesh, int t, Vec3<S>& n);

template <class S> struct OnMesh {
  int triangle = -1;
  OnTriangle<S> at;
  bool inside = false;  // of a closed mesh
};
template <class S> OnMesh<S> closest_on_mesh(const TriangleMesh<S>& mesh, const Vec3<S>& c);

template <class S> ConvexPiece<S> piece_of(const TriangleMesh<S>& mesh, int t) {
  const auto& triangle = mesh.triangles[t];
  return triangle_piece(mesh.points[triangle.corner[0]], mesh.points[triangle.corner[1]], mesh.points[triangle.corner[2]],
                        triangle.normal);
}
template <class S> Aabb<S> bounds_of(const ConvexPiece<S>& piece, const Placement<S>& place);

// ---- one mesh (in its own axes) against one thing placed in those axes; manifolds in mesh axes ------------------------
template <class S>
void mesh_sphere_contacts(const TriangleMesh<S>& mesh, const Vec3<S>& center, S radius, S margin,
                          std::vector<Manifold<S>>& out);
template <class S>
void mesh_convex_contacts(const TriangleMesh<S>& mesh, const ConvexPiece<S>& b, const Placement<S>& b_in_mesh, S margin,
                          std::vector<Manifold<S>>& out);
template <class S>
void mesh_mesh_contacts(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Placement<S>& b_in_a, S margin,
                        std::vector<Manifold<S>>& out);
template <class S>
Separation<S> mesh_mesh_separation(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Placement<S>& b_in_a);

}  // namespace atwood
