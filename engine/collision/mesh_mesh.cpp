// Two meshes: pairs of triangles whose boxes meet, hit or miss by exact signs.
#include <limits>
#include <utility>

#include "collision/mesh_queries.hpp"
#include "collision/predicates.hpp"

namespace atwood {
namespace {

template <class S>
Corners<S> corners_of(const ConvexPiece<S>& triangle) {
  return {triangle.own[0], triangle.own[1], triangle.own[2]};
}

// Points of contact along a face's normal, of the two the one that needs less way.
template <class S>
void along_a_face(const ConvexPiece<S>& t, const ConvexPiece<S>& u, S margin, Manifold<S>& manifold) {
  const Placement<S> same;
  const Vec3<S> normals[2] = {t.sides[0].normal, -u.sides[0].normal};
  const bool second = overlap_along(t, u, same, normals[1]) < overlap_along(t, u, same, normals[0]);
  for (const bool other : {false, true}) {
    const Meet<S> meet{false, std::numeric_limits<S>::infinity(), normals[second != other], {}, {}};
    contact_points(t, u, same, meet, margin, manifold);
    if (manifold.count > 0) return;
  }
}

// Of meshes whose surfaces do not meet one point tells.
template <class S> bool all_inside(const TriangleMesh<S>& mesh, const TriangleMesh<S>& inner, const Placement<S>& place) {
  if (!mesh.closed || mesh.nodes.empty() || inner.points.empty()) return false;
  const Vec3<S> x = placed(place, inner.points[0]);
  return overlap(mesh.nodes[0].box, Aabb<S>{x, x}) && closest_on_mesh(mesh, x).inside;
}

template <class S>
Manifold<S> way_out_of(const TriangleMesh<S>& mesh, const TriangleMesh<S>& inner, const Placement<S>& place) {
  return way_out(mesh, closest_on_mesh(mesh, place.p_W), place.p_W, [&](const Vec3<S>& n) {
    const Vec3<S> d = turned_back(place, n);
    const Vec3<S>* lowest = &inner.points[0];
    for (const Vec3<S>& p : inner.points)
      if (dot(d, p) < dot(d, *lowest)) lowest = &p;
    return placed(place, *lowest);
  });
}

}  // namespace

template <class S>
void mesh_mesh_contacts(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Placement<S>& b_in_a, S margin,
                        std::vector<Manifold<S>>& out) {
  if (a.nodes.empty() || b.nodes.empty()) return;
  const auto wanted = [&](const Aabb<S>& of_a, const Aabb<S>& of_b) { return overlap(of_a, grown(of_b, margin)); };
  const Placement<S> same;
  const std::size_t from = out.size();
  each_pair_of_triangles(a, b, b_in_a, wanted, [&](int t, int u) {
    const ConvexPiece<S> piece_t = piece_of(a, t), piece_u = placed_piece(b, u, b_in_a);
    if (!overlap(bounds_of(piece_t, same), grown(bounds_of(piece_u, same), margin))) return;
    const bool hit = triangles_meet(corners_of(piece_t), corners_of(piece_u));
    if (!hit && !(margin > S(0))) return;
    Meet<S> meet = nearest_features(piece_t, piece_u, same, hit ? std::numeric_limits<S>::infinity() : margin);
    if (!hit && (meet.beyond || meet.gap > margin)) return;
    Manifold<S> manifold;
    Vec3<S> for_b = turned_back(b_in_a, -meet.normal);
    if (normal_allowed(a, t, meet.normal) && normal_allowed(b, u, for_b))
      contact_points(piece_t, piece_u, same, meet, margin, manifold);
    else along_a_face(piece_t, piece_u, margin, manifold);
    if (manifold.count == 0) return;
    manifold.piece_a = a.given[t], manifold.piece_b = b.given[u];
    out.push_back(manifold);
  });
  if (out.size() > from) return;
  Placement<S> a_in_b;
  for (int k = 0; k < 3; ++k) {
    const Vec3<S>* axis = b_in_a.axis_W;
    a_in_b.axis_W[k] = k == 0   ? Vec3<S>{axis[0].x, axis[1].x, axis[2].x}
                       : k == 1 ? Vec3<S>{axis[0].y, axis[1].y, axis[2].y}
                                : Vec3<S>{axis[0].z, axis[1].z, axis[2].z};
  }
  a_in_b.p_W = -turned_back(b_in_a, b_in_a.p_W);
  if (all_inside(a, b, b_in_a)) {
    out.push_back(way_out_of(a, b, b_in_a));
  } else if (all_inside(b, a, a_in_b)) {
    Manifold<S> manifold = way_out_of(b, a, a_in_b);
    manifold.normal_W = turned(b_in_a, -manifold.normal_W);
    manifold.points[0].x_W = placed(b_in_a, manifold.points[0].x_W);
    std::swap(manifold.piece_a, manifold.piece_b);
    out.push_back(manifold);
  }
}

template <class S>
Separation<S> mesh_mesh_separation(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Placement<S>& b_in_a) {
  Separation<S> nearest{std::numeric_limits<S>::infinity(), {S(0), S(0), S(1)}, {}, b_in_a.p_W};
  if (a.nodes.empty() || b.nodes.empty()) return nearest;
  const auto wanted = [&](const Aabb<S>& of_a, const Aabb<S>& of_b) { return distance_between(of_a, of_b) < nearest.gap; };
  each_pair_of_triangles(a, b, b_in_a, wanted, [&](int t, int u) {
    const Meet<S> meet =
        nearest_features(piece_of(a, t), placed_piece(b, u, b_in_a), Placement<S>{}, real::max(nearest.gap, S(0)));
    if (!meet.beyond && meet.gap < nearest.gap) nearest = {meet.gap, meet.normal, meet.on_a, meet.on_b};
  });
  return nearest;
}

#define ATWOOD_MESH_MESH(S)                                                                                          \
  template void mesh_mesh_contacts<S>(const TriangleMesh<S>&, const TriangleMesh<S>&, const Placement<S>&, S,        \
                                      std::vector<Manifold<S>>&);                                                    \
  template Separation<S> mesh_mesh_separation<S>(const TriangleMesh<S>&, const TriangleMesh<S>&, const Placement<S>&);
ATWOOD_MESH_MESH(float)
ATWOOD_MESH_MESH(double)
ATWOOD_MESH_MESH(long double)
#undef ATWOOD_MESH_MESH

}  // namespace atwood
