// A mesh against spheres and against convex pieces, triangle by triangle.
#include <limits>
#include <vector>

#include "collision/mesh_queries.hpp"

namespace atwood {
namespace {

template <class S>
Manifold<S> one_point(const TriangleMesh<S>& mesh, int t, const Vec3<S>& normal, const Vec3<S>& on_mesh, S gap) {
  Manifold<S> manifold;
  manifold.normal_W = normal;
  manifold.count = 1;
  manifold.points[0] = {on_mesh + (gap / S(2)) * normal, gap, 1};
  manifold.piece_a = mesh.given[t];
  return manifold;
}

// Triangles with an edge or corner in common find the same point there, up to the slack of regions at sharp corners.
template <class S>
bool known(const std::vector<Manifold<S>>& out, std::size_t from, const Manifold<S>& made, S tolerance) {
  for (std::size_t i = from; i < out.size(); ++i)
    if (norm(out[i].points[0].x_W - made.points[0].x_W) <= tolerance) return true;
  return false;
}

// The point of a placed piece that lies least along n: in the middle of those that do by round-off.
template <class S> Vec3<S> lowest_of(const ConvexPiece<S>& piece, const Placement<S>& place, const Vec3<S>& n) {
  const Vec3<S> d = turned_back(place, -n);
  int vertex = 0, count = 0;
  Vec3<S> deepest = support(piece, d, vertex), sum;
  if (!piece.polyhedral() && norm(Vec3<S>{d.x, d.y, S(0)}) <= S(8) * real::epsilon<S>()) deepest.x = deepest.y = S(0);
  const S level = dot(d, deepest) - S(32) * real::epsilon<S>() * norm(deepest);
  for (const Vec3<S>& v : piece.vertices())
    if (dot(d, v) >= level) sum += v, ++count;
  return placed(place, count > 0 ? (S(1) / S(count)) * sum : deepest) - piece.radius * n;
}

}  // namespace

template <class S>
void mesh_sphere_contacts(const TriangleMesh<S>& mesh, const Vec3<S>& center, S radius, S margin,
                          std::vector<Manifold<S>>& out) {
  const S reach = radius + margin;
  const S tolerance = S(32) * real::epsilon<S>() * (norm(center) + radius);
  const std::size_t from = out.size();
  const Aabb<S> box = grown(Aabb<S>{center, center}, reach * (S(1) + S(8) * real::epsilon<S>()) + tolerance);
  bool behind = false;  // something near is seen from inside
  each_triangle(mesh, box, [&](int t) {
    OnTriangle<S> at = closest_on_triangle(mesh, t, center, tolerance);
    if (at.distance > reach) return;
    const Vec3<S> away = center - at.x;
    const Vec3<S>& face = mesh.triangles[t].normal;
    if (mesh.closed && dot(away, outwards(mesh, t, at)) < S(0)) return static_cast<void>(behind = true);
    if (!in_region(mesh, t, at, away, S(4) * tolerance)) return;
    Vec3<S> normal = face;
    if (at.part == OnTriangle<S>::face || !(at.distance > tolerance)) {
      if (dot(away, face) < S(0)) normal = -face;
    } else {
      normal = unit_along(away);
    }
    const Manifold<S> made = one_point(mesh, t, normal, at.x, at.distance - radius);
    if (!known(out, from, made, S(256) * tolerance)) out.push_back(made);
  });
  const auto& root = mesh.nodes;
  if (!mesh.closed || root.empty() || !(behind || out.size() == from) || !overlap(root[0].box, Aabb<S>{center, center}))
    return;
  const OnMesh<S> nearest = closest_on_mesh(mesh, center);
  if (!nearest.inside) return;
  out.resize(from);
  out.push_back(way_out(mesh, nearest, center, [&](const Vec3<S>& n) { return center - radius * n; }));
}

template <class S>
void mesh_convex_contacts(const TriangleMesh<S>& mesh, const ConvexPiece<S>& b, const Placement<S>& b_in_mesh, S margin,
                          std::vector<Manifold<S>>& out) {
  const Aabb<S> box = grown(bounds_of(b, b_in_mesh), margin);
  const std::size_t from = out.size();
  const S reach = margin + b.radius;
  const S round_off =
      S(64) * real::epsilon<S>() * (mesh.bounding_radius + norm(b_in_mesh.p_W) + norm(box.high - box.low));
  int left = -1;  // the nearest triangle, whose normal the others may have left to each other
  Meet<S> left_meet;
  struct AlongFace {
    int t;
    S side, way;
  };
  static thread_local std::vector<AlongFace> along_faces;
  static thread_local OwnDepths<S> own;
  along_faces.clear(), own.clear();
  const auto add = [&](int t, const Meet<S>& meet) {
    Manifold<S> manifold;
    contact_points(piece_of(mesh, t), b, b_in_mesh, meet, margin, manifold);
    if (manifold.count == 0) return;
    manifold.piece_a = mesh.given[t];
    out.push_back(manifold);
  };
  each_triangle(mesh, box, [&](int t) {
    const ConvexPiece<S> triangle = piece_of(mesh, t);
    if (!overlap(box, bounds_of(triangle, Placement<S>{}))) return;
    Meet<S> meet = nearest_features(triangle, b, b_in_mesh, reach);
    if (meet.beyond || meet.gap > reach) return;
    if (left < 0 || meet.gap < left_meet.gap) left = t, left_meet = meet;
    const Vec3<S>& face = mesh.triangles[t].normal;
    const Vec3<S> found = meet.normal;
    if (normal_allowed(mesh, t, meet.normal)) {
      own.add(t, -meet.gap);
      return add(t, meet);
    }
    // The neighbours have what is at this edge or corner; what lies over the face itself is left.
    const S front = overlap_along(triangle, b, b_in_mesh, face), back = overlap_along(triangle, b, b_in_mesh, -face);
    if (mesh.closed && (meet.gap > S(0) ? dot(found, face) < S(0) : front > back)) return;
    along_faces.push_back({t, front <= back ? S(1) : S(-1), real::min(front, back)});
  });
  for (const auto& [t, side, way] : along_faces) {
    const auto way_past = [&, side = side](int s) {
      return own.least(s, overlap_along(piece_of(mesh, s), b, b_in_mesh, side * mesh.triangles[s].normal));
    };
    if (way > round_off && neighbour_needs_less(mesh, t, side, way - round_off, way_past)) continue;
    add(t, Meet<S>{false, std::numeric_limits<S>::infinity(), side * mesh.triangles[t].normal, {}, {}});
  }
  if (out.size() > from || mesh.nodes.empty()) return;
  if (mesh.closed && overlap(mesh.nodes[0].box, Aabb<S>{b_in_mesh.p_W, b_in_mesh.p_W})) {
    const OnMesh<S> nearest = closest_on_mesh(mesh, b_in_mesh.p_W);
    const auto lowest = [&](const Vec3<S>& n) { return lowest_of(b, b_in_mesh, n); };
    if (nearest.inside) return out.push_back(way_out(mesh, nearest, b_in_mesh.p_W, lowest));
  }
  if (left < 0) return;
  // Where a surface cuts itself each triangle may leave its normal to a neighbour: then the nearest speaks for all.
  Manifold<S> manifold;
  contact_points(piece_of(mesh, left), b, b_in_mesh, left_meet, margin, manifold);
  if (manifold.count == 0) {  // no more than the point that is known
    manifold.normal_W = left_meet.normal;
    manifold.count = 1;
    const S gap = left_meet.gap - b.radius;
    manifold.points[0] = {left_meet.on_a + (gap / S(2)) * left_meet.normal, gap, 1};
  }
  manifold.piece_a = mesh.given[left];
  out.push_back(manifold);
}

#define ATWOOD_MESH_PAIRS(S)                                                                                      \
  template void mesh_sphere_contacts<S>(const TriangleMesh<S>&, const Vec3<S>&, S, S, std::vector<Manifold<S>>&); \
  template void mesh_convex_contacts<S>(const TriangleMesh<S>&, const ConvexPiece<S>&, const Placement<S>&, S,    \
                                        std::vector<Manifold<S>>&);
ATWOOD_MESH_PAIRS(float)
ATWOOD_MESH_PAIRS(double)
ATWOOD_MESH_PAIRS(long double)
#undef ATWOOD_MESH_PAIRS

}  // namespace atwood
