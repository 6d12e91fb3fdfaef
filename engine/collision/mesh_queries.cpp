#include "collision/mesh_queries.hpp"

#include <limits>

namespace atwood {

template <class S>
TrianglePoint<S> closest_on_triangle(const TriangleMesh<S>& mesh, int t, const Vec3<S>& c, S tolerance) {
  const auto& triangle = mesh.triangles[t];
  const Vec3<S> p[3] = {mesh.points[triangle.corner[0]], mesh.points[triangle.corner[1]],
                        mesh.points[triangle.corner[2]]};
  TrianglePoint<S> best;
  best.distance = std::numeric_limits<S>::infinity();
  bool above = true;
  for (int k = 0; k < 3; ++k) {
    const Vec3<S> e = p[(k + 1) % 3] - p[k], out = c - p[k];
    const S length = norm(e), beyond = dot(cross(e, triangle.normal), out);
    if (beyond < -tolerance * length) continue;
    above = false;
    const S along = dot(e, out) / length;
    TrianglePoint<S> here;
    if (along <= tolerance) here = {TrianglePoint<S>::corner, k, p[k], S(0)};
    else if (along >= length - tolerance) here = {TrianglePoint<S>::corner, (k + 1) % 3, p[(k + 1) % 3], S(0)};
    else here = {TrianglePoint<S>::edge, k, p[k] + (along / length) * e, S(0)};
    here.distance = norm(c - here.x);
    if (here.distance < best.distance) best = here;
  }
  if (!above) return best;
  const S height = dot(triangle.normal, c - p[0]);
  return {TrianglePoint<S>::face, 0, c - height * triangle.normal, real::abs(height)};
}

template <class S>
bool in_voronoi_region(const TriangleMesh<S>& mesh, int t, const TrianglePoint<S>& at, const Vec3<S>& out,
                       S tolerance) {
  const auto& triangle = mesh.triangles[t];
  if (at.part == TrianglePoint<S>::face) return true;
  if (at.part == TrianglePoint<S>::edge) {
    const int across = triangle.across[at.which];
    if (across < 0) return true;
    const Vec3<S> e = mesh.points[triangle.corner[(at.which + 1) % 3]] - mesh.points[triangle.corner[at.which]];
    return dot(cross(e, mesh.triangles[across].normal), out) <= tolerance * norm(e);  // into the neighbour
  }
  const int v = triangle.corner[at.which];
  for (int i = mesh.first_neighbour[v]; i < mesh.first_neighbour[v + 1]; ++i) {
    const Vec3<S> e = mesh.points[mesh.neighbour_points[i]] - mesh.points[v];
    if (dot(e, out) > tolerance * norm(e)) return false;
  }
  return true;
}

template <class S> Vec3<S> pseudonormal(const TriangleMesh<S>& mesh, int t, const TrianglePoint<S>& at) {
  const auto& triangle = mesh.triangles[t];
  if (at.part == TrianglePoint<S>::corner) return mesh.point_pseudonormals[triangle.corner[at.which]];
  if (at.part == TrianglePoint<S>::edge && triangle.across[at.which] >= 0)
    return triangle.normal + mesh.triangles[triangle.across[at.which]].normal;
  return triangle.normal;
}

template <class S> bool normal_in_region(const TriangleMesh<S>& mesh, int t, Vec3<S>& n) {
  constexpr S same_direction = sizeof(S) == 4 ? S(2e-3) : S(1e-6), slack = S(64) * real::epsilon<S>();
  const auto& triangle = mesh.triangles[t];
  for (const S sign : {S(1), S(-1)}) {
    if (norm(n - sign * triangle.normal) > same_direction) continue;
    n = sign * triangle.normal;
    return sign > S(0) || !mesh.closed;
  }
  S high[3];
  int top = 0;
  for (int k = 0; k < 3; ++k) {
    high[k] = dot(n, mesh.points[triangle.corner[k]] - mesh.points[triangle.corner[0]]);
    if (high[k] > high[top]) top = k;
  }
  TrianglePoint<S> at{TrianglePoint<S>::corner, top, {}, S(0)};
  for (const int k : {top, (top + 2) % 3}) {  // the edges at the top corner
    const S length = norm(mesh.points[triangle.corner[(k + 1) % 3]] - mesh.points[triangle.corner[k]]);
    if (real::abs(high[(k + 1) % 3] - high[k]) <= same_direction * length) at = {TrianglePoint<S>::edge, k, {}, S(0)};
  }
  if (at.part == TrianglePoint<S>::edge && mesh.closed && triangle.edge[at.which] != EdgeKind::convex) return false;
  return in_voronoi_region(mesh, t, at, n, slack) && (!mesh.closed || dot(n, pseudonormal(mesh, t, at)) > S(0));
}

template <class S> MeshPoint<S> closest_on_mesh(const TriangleMesh<S>& mesh, const Vec3<S>& c) {
  MeshPoint<S> nearest;
  S least = std::numeric_limits<S>::infinity();
  nearest_triangles(mesh, Aabb<S>{c, c}, least, [&](int t) {
    const TrianglePoint<S> at = closest_on_triangle(mesh, t, c, S(0));
    if (at.distance < least) least = at.distance, nearest.triangle = t, nearest.at = at;
    return least;
  });
  if (nearest.triangle >= 0 && mesh.closed)
    nearest.inside = dot(c - nearest.at.x, pseudonormal(mesh, nearest.triangle, nearest.at)) < S(0);
  return nearest;
}

template <class S> Aabb<S> bounds_of(const ConvexPart<S>& part, const Transform<S>& pose) {
  S low[3], high[3];
  const Vec3<S> rows[3] = {{pose.axis_W[0].x, pose.axis_W[1].x, pose.axis_W[2].x},
                           {pose.axis_W[0].y, pose.axis_W[1].y, pose.axis_W[2].y},
                           {pose.axis_W[0].z, pose.axis_W[1].z, pose.axis_W[2].z}};
  for (int k = 0; k < 3; ++k) {
    int vertex = 0;
    high[k] = dot(rows[k], support(part, rows[k], vertex));
    low[k] = dot(rows[k], support(part, -rows[k], vertex));
  }
  const Vec3<S>& p = pose.p_W;
  const S slack =
      S(8) * real::epsilon<S>() * (norm(p) + norm(Vec3<S>{high[0] - low[0], high[1] - low[1], high[2] - low[2]}));
  return grown(Aabb<S>{{p.x + low[0], p.y + low[1], p.z + low[2]}, {p.x + high[0], p.y + high[1], p.z + high[2]}},
               part.radius + slack);
}

#define ATWOOD_MESH_QUERIES(S)                                                                                 \
  template TrianglePoint<S> closest_on_triangle<S>(const TriangleMesh<S>&, int, const Vec3<S>&, S);            \
  template bool in_voronoi_region<S>(const TriangleMesh<S>&, int, const TrianglePoint<S>&, const Vec3<S>&, S); \
  template Vec3<S> pseudonormal<S>(const TriangleMesh<S>&, int, const TrianglePoint<S>&);                      \
  template bool normal_in_region<S>(const TriangleMesh<S>&, int, Vec3<S>&);                                    \
  template MeshPoint<S> closest_on_mesh<S>(const TriangleMesh<S>&, const Vec3<S>&);                            \
  template Aabb<S> bounds_of<S>(const ConvexPart<S>&, const Transform<S>&);
ATWOOD_MESH_QUERIES(float)
ATWOOD_MESH_QUERIES(double)
ATWOOD_MESH_QUERIES(long double)
#undef ATWOOD_MESH_QUERIES

}  // namespace atwood
