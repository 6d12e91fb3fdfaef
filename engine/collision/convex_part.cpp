#include "collision/convex_part.hpp"

#include <cmath>

#include "collision/triangle_mesh.hpp"

namespace atwood {
namespace {

// Vertex i of the box lies at +x where bit 0 of i is set, +y where bit 1 is, +z where bit 2 is.
template <class S> const Hull<S>& unit_box() {
  static const Hull<S> hull = make_hull<S>(
      {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}});
  return hull;
}
template <class S> const Hull<S>& unit_rectangle() {
  static const Hull<S> hull = make_hull<S>({{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, 0}});
  return hull;
}
template <class S> const Hull<S>& unit_segment() {
  static const Hull<S> hull = make_hull<S>({{0, 0, -1}, {0, 0, 1}});
  return hull;
}
template <class S> const Hull<S>& unit_point() {
  static const Hull<S> hull = make_hull<S>(std::vector<Real3>{{0, 0, 0}});
  return hull;
}
// The two loops of a triangle's faces, front 0 1 2 and back 2 1 0, without vertices.
template <class S> const Hull<S>& triangle_loops() {
  static const Hull<S> hull = [] {
    Hull<S> loops;
    loops.corners = {0, 1, 2, 2, 1, 0};
    return loops;
  }();
  return hull;
}

template <class S> S signed_as(S size, S sign) { return sign < S(0) ? -size : size; }

template <class S> void set_vertices(ConvexPart<S>& part, const Hull<S>& topology) {
  part.topology = &topology;
  part.own_count = static_cast<int>(topology.vertices.size());
  for (int i = 0; i < part.own_count; ++i) {
    const Vec3<S>& v = topology.vertices[i];
    part.own[i] = {v.x * part.half.x, v.y * part.half.y, v.z * part.half.z};
  }
}

}  // namespace

template <class S> ConvexPart<S> box_part(const Vec3<S>& half_extents) {
  ConvexPart<S> part;
  part.core = half_extents.z > S(0) ? Core::box : Core::rectangle;
  part.half = half_extents;
  set_vertices(part, part.core == Core::box ? unit_box<S>() : unit_rectangle<S>());
  return part;
}

template <class S> bool convex_part(const Geometry<S>& geometry, ConvexPart<S>& part) {
  switch (geometry.kind) {
    case ShapeKind::sphere:
      part.core = Core::point;
      part.radius = geometry.radius;
      set_vertices(part, unit_point<S>());
      return true;
    case ShapeKind::capsule:
      part.core = Core::segment;
      part.radius = geometry.radius;
      part.half = {S(0), S(0), geometry.half_length};
      set_vertices(part, unit_segment<S>());
      return true;
    case ShapeKind::rectangle:
    case ShapeKind::box: part = box_part(geometry.half_extents); return true;
    case ShapeKind::cylinder:
      part.core = Core::cylinder;
      part.half = {geometry.radius, geometry.radius, geometry.half_length};
      return true;
    case ShapeKind::convex:
      part.core = Core::hull;
      part.topology = geometry.hull.get();
      return part.topology && !part.topology->vertices.empty();
    case ShapeKind::mesh:
      part.core = Core::hull;
      part.topology = geometry.mesh ? geometry.mesh->solid.get() : nullptr;
      return part.topology != nullptr;
    default: return false;
  }
}

template <class S>
ConvexPart<S> triangle_part(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c, const Vec3<S>& normal) {
  ConvexPart<S> part;
  part.core = Core::triangle;
  part.topology = &triangle_loops<S>();
  part.own_count = 3;
  part.own[0] = a, part.own[1] = b, part.own[2] = c;
  part.triangle_faces[0] = {normal, dot(normal, a), 0, 3};
  part.triangle_faces[1] = {-normal, -dot(normal, a), 3, 3};
  for (int k = 0; k < 3; ++k)
    part.triangle_edges[k] = {k, (k + 1) % 3, 0, 1, unit_vector(part.own[(k + 1) % 3] - part.own[k])};
  return part;
}

template <class S> Vec3<S> support(const ConvexPart<S>& part, const Vec3<S>& d, int& vertex) {
  const Vec3<S>& h = part.half;
  switch (part.core) {
    case Core::point: vertex = 0; return {};
    case Core::segment: vertex = d.z > S(0) ? 1 : 0; return part.own[vertex];
    case Core::rectangle: vertex = (d.x > S(0) ? 1 : 0) + (d.y > S(0) ? 2 : 0); return part.own[vertex];
    case Core::box:
      vertex = (d.x > S(0) ? 1 : 0) + (d.y > S(0) ? 2 : 0) + (d.z > S(0) ? 4 : 0);
      return part.own[vertex];
    case Core::triangle: {
      const S a = dot(d, part.own[0]), b = dot(d, part.own[1]), c = dot(d, part.own[2]);
      vertex = a >= b ? (a >= c ? 0 : 2) : (b >= c ? 1 : 2);
      return part.own[vertex];
    }
    case Core::hull:
      vertex = farthest_vertex(*part.topology, d, real::max(vertex, 0));
      return part.topology->vertices[vertex];
    case Core::cylinder: break;
  }
  vertex = -1;
  const Vec3<S> radial = unit_vector(Vec3<S>{d.x, d.y, S(0)});
  return {h.x * radial.x, h.x * radial.y, signed_as(h.z, d.z)};
}

template <class S> Transform<S> relative_transform(const Transform<S>& pose_a, const Transform<S>& pose_b) {
  return {to_body(pose_a, pose_b.p_W - pose_a.p_W),
          {to_body(pose_a, pose_b.axis_W[0]), to_body(pose_a, pose_b.axis_W[1]), to_body(pose_a, pose_b.axis_W[2])}};
}

#define ATWOOD_CONVEX_PART(S)                                                                              \
  template bool convex_part<S>(const Geometry<S>&, ConvexPart<S>&);                                        \
  template ConvexPart<S> box_part<S>(const Vec3<S>&);                                                      \
  template ConvexPart<S> triangle_part<S>(const Vec3<S>&, const Vec3<S>&, const Vec3<S>&, const Vec3<S>&); \
  template Vec3<S> support<S>(const ConvexPart<S>&, const Vec3<S>&, int&);                                 \
  template Transform<S> relative_transform<S>(const Transform<S>&, const Transform<S>&);
ATWOOD_CONVEX_PART(float)
ATWOOD_CONVEX_PART(double)
ATWOOD_CONVEX_PART(long double)
#undef ATWOOD_CONVEX_PART

}  // namespace atwood
