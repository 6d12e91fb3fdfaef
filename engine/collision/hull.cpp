#include "collision/hull.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "collision/hull_triangles.hpp"

namespace atwood {
namespace {

using Long3 = Vec3<long double>;
using Loops = std::vector<std::vector<int>>;  // faces, anticlockwise from outside

Long3 wide(const Real3& p) { return narrow3<long double>(p); }

// Twice the area times the unit normal (Newell): the sum of x_i cross x_(i+1) about the first corner.
Long3 area_vector(const std::vector<Real3>& points, const std::vector<int>& loop) {
  Long3 sum;
  const Long3 at = wide(points[loop[0]]);
  for (std::size_t i = 2; i < loop.size(); ++i)
    sum += cross(wide(points[loop[i - 1]]) - at, wide(points[loop[i]]) - at);
  return sum;
}
Long3 unit(const Long3& v) {
  const long double size = norm(v);
  return size > 0 ? (1 / size) * v : v;
}

double extent(const std::vector<Real3>& points) {
  double size = 0;
  for (const Real3& p : points) size = std::max(size, static_cast<double>(norm(wide(p) - wide(points[0]))));
  return size;
}

// Coplanar, collinear or coincident points: the outline seen from both sides (Andrew's monotone chain).
Loops flat_outline(const std::vector<Real3>& points) {
  const auto farthest = [&](auto measure) {
    int best = 0;
    for (int i = 1; i < static_cast<int>(points.size()); ++i)
      if (measure(i) > measure(best)) best = i;
    return best;
  };
  if (points.empty()) return {};
  const int a = farthest([&](int i) { return norm(wide(points[i]) - wide(points[0])); });
  const Long3 at = wide(points[a]);
  const int b = farthest([&](int i) { return norm(wide(points[i]) - at); });
  const Long3 x = unit(wide(points[b]) - at);
  if (norm(x) == 0) return {{a}};
  const auto across = [&](int i) { return cross(x, wide(points[i]) - at); };
  const int c = farthest([&](int i) { return norm(across(i)); });
  if (norm(across(c)) <= 64 * 0x1p-52L * norm(wide(points[b]) - at)) return {{a, b}};
  const Long3 z = unit(across(c)), y = cross(z, x);
  const long double straight = 32 * 0x1p-52L * norm(wide(points[b]) - at);  // a corner nearer to its chord is none
  struct Flat {
    long double u, v;
    int index;
  };
  std::vector<Flat> sorted;
  for (int i = 0; i < static_cast<int>(points.size()); ++i)
    sorted.push_back({dot(x, wide(points[i]) - at), dot(y, wide(points[i]) - at), i});
  std::sort(sorted.begin(), sorted.end(),
            [](const Flat& p, const Flat& q) { return std::pair(p.u, p.v) < std::pair(q.u, q.v); });
  const auto half = [&](auto from, auto to) {
    std::vector<Flat> chain;
    for (auto p = from; p != to; ++p) {
      while (chain.size() > 1) {
        const Flat &o = chain[chain.size() - 2], &q = chain.back();
        const long double du = p->u - o.u, dv = p->v - o.v;
        if ((q.u - o.u) * dv - (q.v - o.v) * du > straight * std::sqrt(du * du + dv * dv)) break;
        chain.pop_back();
      }
      chain.push_back(*p);
    }
    return chain;
  };
  const std::vector<Flat> below = half(sorted.begin(), sorted.end()), above = half(sorted.rbegin(), sorted.rend());
  std::vector<int> front;
  for (std::size_t i = 0; i + 1 < below.size(); ++i) front.push_back(below[i].index);
  for (std::size_t i = 0; i + 1 < above.size(); ++i) front.push_back(above[i].index);
  return {front, std::vector<int>(front.rbegin(), front.rend())};
}

// The group of each triangle, by number. A group is grown from its largest triangle across edges, by triangles that lie
// in the plane of that one up to round-off.
std::vector<int> coplanar_groups(const std::vector<Real3>& points, const std::vector<std::array<int, 3>>& triangles) {
  const int n = static_cast<int>(triangles.size());
  const long double tolerance = 32 * 0x1p-52L * extent(points);
  std::map<std::pair<int, int>, int> of_edge;
  std::vector<Long3> area(n);
  std::vector<int> by_area(n), group(n, -1);
  for (int t = 0; t < n; ++t) {
    for (int k = 0; k < 3; ++k) of_edge[{triangles[t][k], triangles[t][(k + 1) % 3]}] = t;
    area[t] = area_vector(points, {triangles[t].begin(), triangles[t].end()});
    by_area[t] = t;
  }
  std::stable_sort(by_area.begin(), by_area.end(),
                   [&](int s, int t) { return dot(area[s], area[s]) > dot(area[t], area[t]); });
  int groups = 0;
  for (const int seed : by_area) {
    if (group[seed] >= 0) continue;
    const Long3 normal = unit(area[seed]), at = wide(points[triangles[seed][0]]);
    std::vector<int> front = {seed};
    group[seed] = groups;
    while (!front.empty()) {
      const auto from = triangles[front.back()];
      front.pop_back();
      for (int k = 0; k < 3; ++k) {
        const int next = of_edge.at({from[(k + 1) % 3], from[k]});
        const bool on_plane = std::all_of(triangles[next].begin(), triangles[next].end(), [&](int corner) {
          return real::abs(dot(normal, wide(points[corner]) - at)) <= tolerance;
        });
        if (group[next] >= 0 || !on_plane || dot(normal, area[next]) < 0) continue;
        group[next] = groups;
        front.push_back(next);
      }
    }
    ++groups;
  }
  return group;
}

// The outline of each group, without corners that lie within an edge of two faces.
Loops merged_faces(const std::vector<Real3>& points, const std::vector<std::array<int, 3>>& triangles) {
  const std::vector<int> group = coplanar_groups(points, triangles);
  const int groups = *std::max_element(group.begin(), group.end()) + 1;
  std::vector<std::map<int, int>> next(groups);
  std::vector<std::set<int>> faces_at(points.size());
  std::map<std::pair<int, int>, int> group_of;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) group_of[{triangles[t][k], triangles[t][(k + 1) % 3]}] = group[t];
  for (const auto& [edge, g] : group_of) {
    faces_at[edge.first].insert(g);
    if (group_of.at({edge.second, edge.first}) != g) next[g][edge.first] = edge.second;
  }
  Loops loops;
  for (const auto& outline : next) {
    std::vector<int> loop;
    const int start = outline.begin()->first;
    for (int corner = start; loop.empty() || corner != start; corner = outline.at(corner)) loop.push_back(corner);
    std::erase_if(loop, [&](int corner) { return faces_at[corner].size() < 3; });
    loops.push_back(loop);
  }
  return loops;
}

template <class S> Vec3<S> narrow(const Long3& v) { return {S(v.x), S(v.y), S(v.z)}; }

template <class S> void add_edges(Hull<S>& hull) {
  std::map<std::pair<int, int>, int> of_edge;
  for (int f = 0; f < static_cast<int>(hull.faces.size()); ++f) {
    const auto& face = hull.faces[f];
    for (int k = 0; k < face.count; ++k)
      of_edge[{hull.corners[face.first + k], hull.corners[face.first + (k + 1) % face.count]}] = f;
  }
  if (hull.faces.empty() && hull.vertices.size() == 2) hull.edges.push_back({0, 1, -1, -1, {}});
  for (const auto& [edge, left] : of_edge)
    if (const auto back = of_edge.find({edge.second, edge.first}); edge.first < edge.second && back != of_edge.end())
      hull.edges.push_back({edge.first, edge.second, left, back->second, {}});
  std::vector<std::vector<int>> around(hull.vertices.size());
  for (auto& edge : hull.edges) {
    const Vec3<S> along = hull.vertices[edge.to] - hull.vertices[edge.from];
    edge.along = narrow<S>(unit({along.x, along.y, along.z}));
    around[edge.from].push_back(edge.to);
    around[edge.to].push_back(edge.from);
  }
  for (const auto& of_vertex : around) {
    hull.first_neighbour.push_back(static_cast<int>(hull.neighbours.size()));
    hull.neighbours.insert(hull.neighbours.end(), of_vertex.begin(), of_vertex.end());
  }
  hull.first_neighbour.push_back(static_cast<int>(hull.neighbours.size()));
}

}  // namespace

template <class S> Hull<S> make_hull(const std::vector<Real3>& points) {
  const std::vector<std::array<int, 3>> triangles = hull_triangles(points);
  const Loops loops = triangles.empty() ? flat_outline(points) : merged_faces(points, triangles);
  Hull<S> hull;
  std::map<int, int> vertex_of;
  for (const auto& loop : loops)
    for (const int corner : loop) vertex_of[corner] = 0;
  Long3 sum;
  for (auto& [corner, vertex] : vertex_of) {
    vertex = static_cast<int>(hull.vertices.size());
    hull.vertices.push_back(narrow3<S>(points[corner]));
    hull.bounding_radius = real::max(hull.bounding_radius, norm(hull.vertices.back()));
    sum += wide(points[corner]);
  }
  if (!hull.vertices.empty()) hull.inside = narrow<S>((1 / static_cast<long double>(hull.vertices.size())) * sum);
  for (const auto& loop : loops) {
    if (loop.size() < 3) continue;
    const Long3 normal = unit(area_vector(points, loop));
    long double offset = dot(normal, wide(points[loop[0]]));
    for (const int corner : loop) offset = std::max(offset, dot(normal, wide(points[corner])));
    hull.faces.push_back(
        {narrow<S>(normal), S(offset), static_cast<int>(hull.corners.size()), static_cast<int>(loop.size())});
    for (const int corner : loop) hull.corners.push_back(vertex_of.at(corner));
  }
  add_edges(hull);
  return hull;
}

template <class S> int farthest_vertex(const Hull<S>& hull, const Vec3<S>& direction, int start) {
  const int n = static_cast<int>(hull.vertices.size());
  constexpr int max_vertices_to_scan = 32;  // looking at all of them is faster
  if (n <= max_vertices_to_scan) {
    int best = 0;
    S most = dot(direction, hull.vertices[0]);
    for (int i = 1; i < n; ++i)
      if (const S here = dot(direction, hull.vertices[i]); here > most) most = here, best = i;
    return best;
  }
  S most = dot(direction, hull.vertices[start]);
  for (int at = start;;) {
    const int before = at;
    for (int k = hull.first_neighbour[before]; k < hull.first_neighbour[before + 1]; ++k)
      if (const S here = dot(direction, hull.vertices[hull.neighbours[k]]); here > most)
        most = here, at = hull.neighbours[k];
    if (at == before) return at;
  }
}

#define ATWOOD_HULL(S)                                      \
  template Hull<S> make_hull<S>(const std::vector<Real3>&); \
  template int farthest_vertex<S>(const Hull<S>&, const Vec3<S>&, int);
ATWOOD_HULL(float)
ATWOOD_HULL(double)
ATWOOD_HULL(long double)
#undef ATWOOD_HULL

}  // namespace atwood
