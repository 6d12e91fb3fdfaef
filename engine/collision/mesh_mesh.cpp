// Two meshes: pairs of triangles whose boxes meet, hit or miss by exact signs.
#include <limits>
#include <utility>
#include <vector>

#include "collision/mesh_queries.hpp"
#include "collision/predicates.hpp"

namespace atwood {
namespace {

template <class S> Corners<S> corners_of(const ConvexPiece<S>& triangle) {
  return {triangle.own[0], triangle.own[1], triangle.own[2]};
}

template <class S> struct Triangles {
  const TriangleMesh<S>&a, &b;
  const Placement<S>& b_in_a;
  int t, u;
  ConvexPiece<S> piece_t, piece_u;  // both in A's axes
};

// Points of contact along a face's normal, of the two the one that needs less way. A normal is left to a neighbour of
// the face that needs less (mesh_queries.hpp).
template <class S>
void along_a_face(const Triangles<S>& of, const OwnDepths<S>& own_a, const OwnDepths<S>& own_b, S margin, S round_off,
                  Manifold<S>& manifold) {
  const Placement<S> same;
  const ConvexPiece<S>&t = of.piece_t, &u = of.piece_u;
  const Vec3<S> normals[2] = {t.sides[0].normal, -u.sides[0].normal};
  const S ways[2] = {overlap_along(t, u, same, normals[0]), overlap_along(t, u, same, normals[1])};
  const auto past_a = [&](int s) {
    return own_a.least(s, overlap_along(piece_of(of.a, s), u, same, of.a.triangles[s].normal));
  };
  const auto past_b = [&](int s) {
    const ConvexPiece<S> piece = placed_piece(of.b, s, of.b_in_a);
    return own_b.least(s, overlap_along(t, piece, same, -piece.sides[0].normal));
  };
  const bool second = ways[1] < ways[0];
  for (const bool other : {false, true}) {
    const bool of_u = second != other;
    const S way = ways[of_u] - round_off;
    if (way > S(0) && (of_u ? neighbour_needs_less(of.b, of.u, S(1), way, past_b)
                            : neighbour_needs_less(of.a, of.t, S(1), way, past_a)))
      continue;
    const Meet<S> meet{false, std::numeric_limits<S>::infinity(), normals[of_u], {}, {}};
    contact_points(t, u, same, meet, margin, manifold);
    if (manifold.count > 0) return;
  }
}

// Of meshes whose surfaces do not meet one point tells.
template <class S>
bool all_inside(const TriangleMesh<S>& mesh, const TriangleMesh<S>& inner, const Placement<S>& place) {
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
  const S round_off = S(64) * real::epsilon<S>() * (a.bounding_radius + b.bounding_radius + norm(b_in_a.p_W));
  int left_t = -1, left_u = -1;  // the nearest triangles whose contact may be left to neighbours
  Meet<S> left_meet;
  static thread_local std::vector<Triangles<S>> along_faces;
  static thread_local OwnDepths<S> own_a, own_b;
  along_faces.clear(), own_a.clear(), own_b.clear();
  const auto add = [&](int t, int u, Manifold<S>& manifold) {
    if (manifold.count == 0) return;
    manifold.piece_a = a.given[t], manifold.piece_b = b.given[u];
    out.push_back(manifold);
  };
  each_pair_of_triangles(a, b, b_in_a, wanted, [&](int t, int u) {
    const ConvexPiece<S> piece_t = piece_of(a, t), piece_u = placed_piece(b, u, b_in_a);
    if (!overlap(bounds_of(piece_t, same), grown(bounds_of(piece_u, same), margin))) return;
    const bool hit = triangles_meet(corners_of(piece_t), corners_of(piece_u));
    if (!hit && !(margin > S(0))) return;
    Meet<S> meet = nearest_features(piece_t, piece_u, same, hit ? std::numeric_limits<S>::infinity() : margin);
    if (!hit && (meet.beyond || meet.gap > margin)) return;
    if (left_t < 0 || meet.gap < left_meet.gap) left_t = t, left_u = u, left_meet = meet;
    Vec3<S> for_b = turned_back(b_in_a, -meet.normal);
    if (!normal_allowed(a, t, meet.normal) || !normal_allowed(b, u, for_b)) {
      along_faces.push_back({a, b, b_in_a, t, u, piece_t, piece_u});
      return;
    }
    own_a.add(t, -meet.gap);
    own_b.add(u, -meet.gap);
    Manifold<S> manifold;
    contact_points(piece_t, piece_u, same, meet, margin, manifold);
    add(t, u, manifold);
  });
  for (const Triangles<S>& pair : along_faces) {
    Manifold<S> manifold;
    along_a_face(pair, own_a, own_b, margin, round_off, manifold);
    add(pair.t, pair.u, manifold);
  }
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
  } else if (left_t >= 0) {
    Manifold<S> manifold;
    contact_points(piece_of(a, left_t), placed_piece(b, left_u, b_in_a), same, left_meet, margin, manifold);
    add(left_t, left_u, manifold);
  }
}

template <class S>
Separation<S> mesh_mesh_separation(const TriangleMesh<S>& a, const TriangleMesh<S>& b, const Placement<S>& b_in_a) {
  Separation<S> nearest{std::numeric_limits<S>::infinity(), {S(0), S(0), S(1)}, {}, b_in_a.p_W};
  if (a.nodes.empty() || b.nodes.empty()) return nearest;
  const auto wanted = [&](const Aabb<S>& of_a, const Aabb<S>& of_b) {
    return distance_between(of_a, of_b) < nearest.gap;
  };
  each_pair_of_triangles(a, b, b_in_a, wanted, [&](int t, int u) {
    const Meet<S> meet =
        nearest_features(piece_of(a, t), placed_piece(b, u, b_in_a), Placement<S>{}, real::max(nearest.gap, S(0)));
    if (!meet.beyond && meet.gap < nearest.gap) nearest = {meet.gap, meet.normal, meet.on_a, meet.on_b};
  });
  return nearest;
}

#define ATWOOD_MESH_MESH(S)                                                                                   \
  template void mesh_mesh_contacts<S>(const TriangleMesh<S>&, const TriangleMesh<S>&, const Placement<S>&, S, \
                                      std::vector<Manifold<S>>&);                                             \
  template Separation<S> mesh_mesh_separation<S>(const TriangleMesh<S>&, const TriangleMesh<S>&, const Placement<S>&);
ATWOOD_MESH_MESH(float)
ATWOOD_MESH_MESH(double)
ATWOOD_MESH_MESH(long double)
#undef ATWOOD_MESH_MESH

}  // namespace atwood
