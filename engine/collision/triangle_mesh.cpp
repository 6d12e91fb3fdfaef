// Builds a mesh: equal points are merged, triangles without area are dropped, and edges, their kinds, pseudonormals and
// the bounding-volume tree follow from the triangles that are left.
#include "collision/triangle_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "collision/hull.hpp"

namespace atwood {
namespace {

using Long3 = Vec3<long double>;
using DirectedEdge = std::pair<int, int>;

Long3 wide(const Real3& p) { return narrow3<long double>(p); }
Long3 unit_of(const Long3& v) { return (1 / norm(v)) * v; }
template <class S> Vec3<S> narrow(const Long3& v) { return {S(v.x), S(v.y), S(v.z)}; }

// The mesh in double: every scalar's mesh is rounded from here.
struct Source {
  std::vector<Real3> points;
  std::vector<std::array<int, 3>> corner;
  std::vector<int> scene_index;
  std::vector<Long3> normal;
};

Source merge_points(const std::vector<Real3>& points, const std::vector<std::array<int, 3>>& triangles) {
  Source source;
  std::map<Real3, int> index_of;
  std::vector<int> same(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Real3 key{points[i][0] + 0.0, points[i][1] + 0.0, points[i][2] + 0.0};  // -0 is 0
    const auto [at, is_new] = index_of.try_emplace(key, static_cast<int>(source.points.size()));
    if (is_new) source.points.push_back(key);
    same[i] = at->second;
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::array<int, 3> c{same[triangles[t][0]], same[triangles[t][1]], same[triangles[t][2]]};
    const Long3 area = cross(wide(source.points[c[1]]) - wide(source.points[c[0]]),
                             wide(source.points[c[2]]) - wide(source.points[c[0]]));
    if (!(dot(area, area) > 0)) continue;
    source.corner.push_back(c);
    source.scene_index.push_back(static_cast<int>(t));
    source.normal.push_back(unit_of(area));
  }
  return source;
}

// Builds the tree: splits at the median centroid along the longest side until two triangles are left.
template <class S> struct TreeBuilder {
  const Source& source;
  std::vector<int> order;
  TriangleMesh<S>& mesh;

  Real3 three_times_centroid(int t) const {
    Real3 sum{};
    for (const int c : source.corner[t])
      for (int k = 0; k < 3; ++k) sum[k] += source.points[c][k];
    return sum;
  }
  Aabb<S> box_of(int first, int count) const {
    Aabb<S> box;
    for (int i = first; i < first + count; ++i)
      for (int k = 0; k < 3; ++k) {
        const Vec3<S> p = narrow3<S>(source.points[source.corner[order[i]][k]]);
        if (i == first && k == 0) box = {p, p};
        box.low = {real::min(box.low.x, p.x), real::min(box.low.y, p.y), real::min(box.low.z, p.z)};
        box.high = {real::max(box.high.x, p.x), real::max(box.high.y, p.y), real::max(box.high.z, p.z)};
      }
    return box;
  }
  int build(int first, int count) {
    constexpr int leaf_size = 2;
    const int node = static_cast<int>(mesh.nodes.size());
    mesh.nodes.push_back({box_of(first, count), -1, first, count});
    if (count <= leaf_size) return node;
    Real3 low = three_times_centroid(order[first]), high = low;
    for (int i = first; i < first + count; ++i)
      for (int k = 0; k < 3; ++k)
        low[k] = std::min(low[k], three_times_centroid(order[i])[k]),
        high[k] = std::max(high[k], three_times_centroid(order[i])[k]);
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    const int half = count / 2;
    std::nth_element(order.begin() + first, order.begin() + first + half, order.begin() + first + count,
                     [&](int s, int t) {
                       return std::pair(three_times_centroid(s)[axis], s) < std::pair(three_times_centroid(t)[axis], t);
                     });
    mesh.nodes[node].count = 0;
    build(first, half);
    mesh.nodes[node].right = build(first + half, count - half);
    return node;
  }
};

// Across an edge from t: convex when the neighbour's third corner lies below t's plane, by a sine of more than 1e-10.
EdgeKind kind_of(const Source& source, int t, int k, int next) {
  constexpr long double max_flat_sine = 1e-10L;
  const Long3 from = wide(source.points[source.corner[t][k]]), to = wide(source.points[source.corner[t][(k + 1) % 3]]);
  for (const int c : source.corner[next]) {
    if (c == source.corner[t][k] || c == source.corner[t][(k + 1) % 3]) continue;
    const Long3 out = wide(source.points[c]) - from;
    const long double height = dot(source.normal[t], out), lever = norm(cross(unit_of(to - from), out));
    if (std::abs(height) <= max_flat_sine * lever)
      return dot(source.normal[t], source.normal[next]) > 0 ? EdgeKind::flat : EdgeKind::concave;
    return height < 0 ? EdgeKind::convex : EdgeKind::concave;
  }
  return EdgeKind::concave;  // two triangles on the same three points, back to back
}

template <class S> void add_adjacency(const Source& source, TriangleMesh<S>& mesh) {
  std::map<DirectedEdge, std::vector<int>> of_edge;  // triangles that run along it this way
  const int n = static_cast<int>(mesh.triangles.size());
  for (int t = 0; t < n; ++t)
    for (int k = 0; k < 3; ++k)
      of_edge[{mesh.triangles[t].corner[k], mesh.triangles[t].corner[(k + 1) % 3]}].push_back(t);
  std::vector<std::set<int>> neighbour_points(mesh.points.size());
  mesh.closed = n > 0;
  for (const auto& [edge, owners] : of_edge) {
    neighbour_points[edge.first].insert(edge.second);
    neighbour_points[edge.second].insert(edge.first);
    const auto back = of_edge.find({edge.second, edge.first});
    const bool paired = owners.size() == 1 && back != of_edge.end() && back->second.size() == 1;
    mesh.closed = mesh.closed && paired;
    for (const int t : owners)
      for (int k = 0; k < 3; ++k)
        if (mesh.triangles[t].corner[k] == edge.first && mesh.triangles[t].corner[(k + 1) % 3] == edge.second) {
          mesh.triangles[t].across[k] = paired ? back->second[0] : -1;
          mesh.triangles[t].edge[k] = paired ? kind_of(source, t, k, back->second[0]) : EdgeKind::border;
        }
  }
  for (const auto& of_point : neighbour_points) {
    mesh.first_neighbour.push_back(static_cast<int>(mesh.neighbour_points.size()));
    mesh.neighbour_points.insert(mesh.neighbour_points.end(), of_point.begin(), of_point.end());
  }
  mesh.first_neighbour.push_back(static_cast<int>(mesh.neighbour_points.size()));
}

// True if a closed mesh bounds a convex solid. A connected closed surface without concave edges does; a test of all
// vertices excludes several surfaces. False for more than max_triangles triangles, without a test.
template <class S> bool is_convex(const Source& source, const TriangleMesh<S>& mesh) {
  constexpr std::size_t max_triangles = 4096;
  if (!mesh.closed || mesh.triangles.size() > max_triangles) return false;
  for (const auto& t : mesh.triangles)
    for (const EdgeKind kind : t.edge)
      if (kind == EdgeKind::concave) return false;
  for (std::size_t t = 0; t < source.corner.size(); ++t)
    for (const Real3& p : source.points) {
      const Long3 way = wide(p) - wide(source.points[source.corner[t][0]]);
      if (dot(source.normal[t], way) > 64 * 0x1p-52L * norm(way)) return false;
    }
  return true;
}

template <class S> void add_point_normals(const Source& source, TriangleMesh<S>& mesh) {
  std::vector<Long3> sum(source.points.size());
  for (std::size_t t = 0; t < source.corner.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Long3 at = wide(source.points[source.corner[t][k]]);
      const Long3 u = wide(source.points[source.corner[t][(k + 1) % 3]]) - at,
                  v = wide(source.points[source.corner[t][(k + 2) % 3]]) - at;
      sum[source.corner[t][k]] += real::atan2(norm(cross(u, v)), dot(u, v)) * source.normal[t];
    }
  for (const Long3& normal : sum)
    mesh.point_pseudonormals.push_back(narrow<S>(dot(normal, normal) > 0 ? unit_of(normal) : normal));
}

}  // namespace

template <class S>
TriangleMesh<S> build_triangle_mesh(const std::vector<Real3>& points,
                                    const std::vector<std::array<int, 3>>& triangles) {
  TriangleMesh<S> mesh;
  const Source merged = merge_points(points, triangles);
  const int n = static_cast<int>(merged.corner.size());
  TreeBuilder<S> tree{merged, std::vector<int>(n), mesh};
  std::iota(tree.order.begin(), tree.order.end(), 0);
  if (n > 0) tree.build(0, n);
  Source source{merged.points, {}, {}, {}};
  for (const int t : tree.order) {
    source.corner.push_back(merged.corner[t]);
    source.normal.push_back(merged.normal[t]);
    mesh.scene_index.push_back(merged.scene_index[t]);
    mesh.triangles.push_back({merged.corner[t], {-1, -1, -1}, {}, narrow<S>(merged.normal[t])});
  }
  for (const Real3& p : source.points) mesh.points.push_back(narrow3<S>(p));
  for (const auto& t : mesh.triangles)
    for (const int c : t.corner) mesh.bounding_radius = real::max(mesh.bounding_radius, norm(mesh.points[c]));
  add_adjacency(source, mesh);
  mesh.convex = is_convex(source, mesh);
  if (mesh.convex) {
    constexpr std::size_t max_corners = 64;  // the test of two hulls may try all pairs of their edges
    const auto solid = std::make_shared<const Hull<S>>(make_hull<S>(source.points));
    if (solid->vertices.size() <= max_corners) mesh.solid = solid;
  }
  add_point_normals(source, mesh);
  return mesh;
}

#define ATWOOD_TRIANGLE_MESH(S) \
  template TriangleMesh<S> build_triangle_mesh<S>(const std::vector<Real3>&, const std::vector<std::array<int, 3>>&);
ATWOOD_TRIANGLE_MESH(float)
ATWOOD_TRIANGLE_MESH(double)
ATWOOD_TRIANGLE_MESH(long double)
#undef ATWOOD_TRIANGLE_MESH

}  // namespace atwood
