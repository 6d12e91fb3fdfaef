// Two meshes: pairs of triangles whose boxes meet, hit or miss by exact signs.
#include <limits>

#include "collision/mesh_queries.hpp"
#include "collision/predicates.hpp"

namespace atwood {
namespace {

// The box around a box of B's axes, in A's.
template <class S> Aabb<S> turned_box(const Aabb<S>& box, const Placement<S>& b_in_a) {
  const Vec3<S> center = placed(b_in_a, S(0.5) * (box.low + box.high)), h = S(0.5) * (box.high - box.low);
  const Vec3<S>* axis = b_in_a.axis_W;
  const auto reach = [&](S x, S y, S z) { return real::abs(x) * h.x + real::abs(y) * h.y + real::abs(z) * h.z; };
  const Vec3<S> r{reach(axis[0].x, axis[1].x, axis[2].x), reach(axis[0].y, axis[1].y, axis[2].y),
                  reach(axis[0].z, axis[1].z, axis[2].z)};
  return grown(Aabb<S>{center - r, center + r}, S(16) * real::epsilon<S>() * (norm(center) + norm(r)));
}

// Walks both trees; `visit(t, u)` for leaves while wanted(box of a, box of b in A's axes) holds.
template <class S> struct Walk {
  const TriangleMesh<S>&a, &b;
  const Placement<S>& b_in_a;

  template <class Wanted, class Visit> void down(int m, int n, const Wanted& wanted, const Visit& visit) const {
    const auto &of_a = a.nodes[m], &of_b = b.nodes[n];
    if (!wanted(of_a.box, turned_box(of_b.box, b_in_a))) return;
    if (of_a.right < 0 && of_b.right < 0) {
      for (int t = of_a.first; t < of_a.first + of_a.count; ++t)
        for (int u = of_b.first; u < of_b.first + of_b.count; ++u) visit(t, u);
    } else if (of_b.right < 0 ||
               (of_a.right >= 0 && norm(of_a.box.high - of_a.box.low) >= norm(of_b.box.high - of_b.box.low))) {
      down(m + 1, n, wanted, visit);
      down(of_a.right, n, wanted, visit);
    } else {
      down(m, n + 1, wanted, visit);
      down(m, of_b.right, wanted, visit);
    }
  }
};

template <class S> ConvexPiece<S> placed_piece(const TriangleMesh<S>& mesh, int t, const Placement<S>& place) {
  const auto& triangle = mesh.triangles[t];
  return triangle_piece(placed(place, mesh.points[triangle.corner[0]]), placed(place, mesh.points[triangle.corner[1]]),
                        placed(place, mesh.points[triangle.corner[2]]), turned(place, triangle.normal));
}
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

}  // namespace

template <class S>
void mesh_mesh_contacts(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Placement<S>& b_in_a, S margin,
                        std::vector<Manifold<S>>& out) {
  if (a.nodes.empty() || b.nodes.empty()) return;
  const auto wanted = [&](const Aabb<S>& of_a, const Aabb<S>& of_b) { return overlap(of_a, grown(of_b, margin)); };
  const Placement<S> same;
  Walk<S>{a, b, b_in_a}.down(0, 0, wanted, [&](int t, int u) {
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
}

template <class S>
Separation<S> mesh_mesh_separation(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Placement<S>& b_in_a) {
  Separation<S> nearest{std::numeric_limits<S>::infinity(), {S(0), S(0), S(1)}, {}, b_in_a.p_W};
  if (a.nodes.empty() || b.nodes.empty()) return nearest;
  const auto wanted = [&](const Aabb<S>& of_a, const Aabb<S>& of_b) { return distance_between(of_a, of_b) < nearest.gap; };
  Walk<S>{a, b, b_in_a}.down(0, 0, wanted, [&](int t, int u) {
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
