// A mesh against spheres and against convex parts, triangle by triangle.
#include <limits>
#include <vector>

#include "collision/mesh_queries.hpp"

namespace atwood {
namespace {

template <class S>
Manifold<S> point_manifold(const TriangleMesh<S>& mesh, int t, const Vec3<S>& normal, const Vec3<S>& on_mesh, S gap) {
  Manifold<S> manifold;
  manifold.normal_W = normal;
  manifold.count = 1;
  manifold.points[0] = {on_mesh + (gap / S(2)) * normal, gap, 1};
  manifold.part_a = mesh.scene_index[t];
  return manifold;
}

// Adjacent triangles report the same contact at a shared edge or vertex, within the tolerance of the Voronoi regions.
template <class S>
bool is_duplicate(const std::vector<Manifold<S>>& out, std::size_t first_new, const Manifold<S>& manifold,
                  S tolerance) {
  for (std::size_t i = first_new; i < out.size(); ++i)
    if (norm(out[i].points[0].x_W - manifold.points[0].x_W) <= tolerance) return true;
  return false;
}

// The support point of a placed part along -n; the mean of the vertices that are lowest up to round-off.
template <class S> Vec3<S> lowest_of(const ConvexPart<S>& part, const Transform<S>& pose, const Vec3<S>& n) {
  const Vec3<S> d = to_body(pose, -n);
  int vertex = 0, count = 0;
  Vec3<S> deepest = support(part, d, vertex), sum;
  if (!part.polyhedral() && norm(Vec3<S>{d.x, d.y, S(0)}) <= S(8) * real::epsilon<S>()) deepest.x = deepest.y = S(0);
  const S level = dot(d, deepest) - S(32) * real::epsilon<S>() * norm(deepest);
  for (const Vec3<S>& v : part.vertices())
    if (dot(d, v) >= level) sum += v, ++count;
  return point_to_world(pose, count > 0 ? (S(1) / S(count)) * sum : deepest) - part.radius * n;
}

}  // namespace

template <class S>
void mesh_sphere_contacts(const TriangleMesh<S>& mesh, const Vec3<S>& center, S radius, S margin,
                          std::vector<Manifold<S>>& out) {
  const S max_distance = radius + margin;
  const S tolerance = S(32) * real::epsilon<S>() * (norm(center) + radius);
  const std::size_t first_new = out.size();
  const Aabb<S> box = grown(Aabb<S>{center, center}, max_distance * (S(1) + S(8) * real::epsilon<S>()) + tolerance);
  bool behind = false;  // some near triangle has the centre on its inner side
  each_triangle(mesh, box, [&](int t) {
    TrianglePoint<S> at = closest_on_triangle(mesh, t, center, tolerance);
    if (at.distance > max_distance) return;
    const Vec3<S> away = center - at.x;
    const Vec3<S>& face = mesh.triangles[t].normal;
    if (mesh.closed && dot(away, pseudonormal(mesh, t, at)) < S(0)) {
      behind = true;
      return;
    }
    if (!in_voronoi_region(mesh, t, at, away, S(4) * tolerance)) return;
    Vec3<S> normal = face;
    if (at.part == TrianglePoint<S>::face || !(at.distance > tolerance)) {
      if (dot(away, face) < S(0)) normal = -face;
    } else {
      normal = unit_vector(away);
    }
    const Manifold<S> manifold = point_manifold(mesh, t, normal, at.x, at.distance - radius);
    if (!is_duplicate(out, first_new, manifold, S(256) * tolerance)) out.push_back(manifold);
  });
  const auto& root = mesh.nodes;
  if (!mesh.closed || root.empty() || !(behind || out.size() == first_new) ||
      !overlap(root[0].box, Aabb<S>{center, center}))
    return;
  const MeshPoint<S> nearest = closest_on_mesh(mesh, center);
  if (!nearest.inside) return;
  out.resize(first_new);
  out.push_back(enclosed_manifold(mesh, nearest, center, [&](const Vec3<S>& n) { return center - radius * n; }));
}

// Each triangle that comes near keeps a contact whose normal lies in its own Voronoi region. Any other contact belongs
// to a neighbour, but for one over the face itself, which is kept unless a neighbour is shallower. A part inside a
// closed mesh touches no triangle: it gets the contact of the mesh point nearest to its centre.
template <class S>
void mesh_convex_contacts(const TriangleMesh<S>& mesh, const ConvexPart<S>& b, const Transform<S>& b_in_mesh, S margin,
                          std::vector<Manifold<S>>& out) {
  const Aabb<S> box = grown(bounds_of(b, b_in_mesh), margin);
  const std::size_t first_new = out.size();
  const S max_distance = margin + b.radius;
  const S round_off =
      S(64) * real::epsilon<S>() * (mesh.bounding_radius + norm(b_in_mesh.p_W) + norm(box.high - box.low));
  int closest_t = -1;  // the nearest triangle, used if every contact is assigned to a neighbour
  NearestFeatures<S> closest_features;
  struct FaceContact {
    int t;
    S side, depth;
  };
  static thread_local std::vector<FaceContact> face_contacts;
  static thread_local TriangleDepths<S> depths;
  face_contacts.clear(), depths.clear();
  const auto add = [&](int t, const NearestFeatures<S>& features) {
    Manifold<S> manifold;
    contact_points(part_of(mesh, t), b, b_in_mesh, features, margin, manifold);
    if (manifold.count == 0) return;
    manifold.part_a = mesh.scene_index[t];
    out.push_back(manifold);
  };
  each_triangle(mesh, box, [&](int t) {
    const ConvexPart<S> triangle = part_of(mesh, t);
    if (!overlap(box, bounds_of(triangle, Transform<S>{}))) return;
    NearestFeatures<S> features = nearest_features(triangle, b, b_in_mesh, max_distance);
    if (features.out_of_range || features.gap > max_distance) return;
    if (closest_t < 0 || features.gap < closest_features.gap) closest_t = t, closest_features = features;
    const Vec3<S>& face = mesh.triangles[t].normal;
    const Vec3<S> found = features.normal;
    if (normal_in_region(mesh, t, features.normal)) {
      depths.add(t, -features.gap);
      return add(t, features);
    }
    // The contact at this edge or corner belongs to a neighbour; a contact over the face itself may remain.
    const S front = overlap_along(triangle, b, b_in_mesh, face), back = overlap_along(triangle, b, b_in_mesh, -face);
    if (mesh.closed && (features.gap > S(0) ? dot(found, face) < S(0) : front > back)) return;
    face_contacts.push_back({t, front <= back ? S(1) : S(-1), real::min(front, back)});
  });
  for (const auto& [t, side, depth] : face_contacts) {
    const auto depth_along = [&, side = side](int s) {
      return depths.least(s, overlap_along(part_of(mesh, s), b, b_in_mesh, side * mesh.triangles[s].normal));
    };
    if (depth > round_off && neighbour_is_shallower(mesh, t, side, depth - round_off, depth_along)) continue;
    add(t, NearestFeatures<S>{false, std::numeric_limits<S>::infinity(), side * mesh.triangles[t].normal, {}, {}});
  }
  if (out.size() > first_new || mesh.nodes.empty()) return;
  if (mesh.closed && overlap(mesh.nodes[0].box, Aabb<S>{b_in_mesh.p_W, b_in_mesh.p_W})) {
    const MeshPoint<S> nearest = closest_on_mesh(mesh, b_in_mesh.p_W);
    const auto lowest = [&](const Vec3<S>& n) { return lowest_of(b, b_in_mesh, n); };
    if (nearest.inside) return out.push_back(enclosed_manifold(mesh, nearest, b_in_mesh.p_W, lowest));
  }
  if (closest_t < 0) return;
  // Where a surface intersects itself, every triangle may assign the contact to a neighbour; then the nearest triangle
  // is used.
  Manifold<S> manifold;
  contact_points(part_of(mesh, closest_t), b, b_in_mesh, closest_features, margin, manifold);
  if (manifold.count == 0) {  // the nearest point only
    manifold.normal_W = closest_features.normal;
    manifold.count = 1;
    const S gap = closest_features.gap - b.radius;
    manifold.points[0] = {closest_features.on_a + (gap / S(2)) * closest_features.normal, gap, 1};
  }
  manifold.part_a = mesh.scene_index[closest_t];
  out.push_back(manifold);
}

#define ATWOOD_MESH_PAIRS(S)                                                                                      \
  template void mesh_sphere_contacts<S>(const TriangleMesh<S>&, const Vec3<S>&, S, S, std::vector<Manifold<S>>&); \
  template void mesh_convex_contacts<S>(const TriangleMesh<S>&, const ConvexPart<S>&, const Transform<S>&, S,     \
                                        std::vector<Manifold<S>>&);
ATWOOD_MESH_PAIRS(float)
ATWOOD_MESH_PAIRS(double)
ATWOOD_MESH_PAIRS(long double)
#undef ATWOOD_MESH_PAIRS

}  // namespace atwood
