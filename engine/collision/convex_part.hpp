// One convex shape in the topology that the pair tests use: a core (a polyhedron, or a cylinder) and a radius around
// it.
#pragma once

#include <array>
#include <cmath>
#include <span>

#include "collision/geometry.hpp"
#include "collision/hull.hpp"

namespace atwood {

enum class Core : unsigned char { point, segment, rectangle, box, triangle, hull, cylinder };

// Own axes [m]. A segment and a cylinder lie along z.
template <class S> struct ConvexPart {
  using Face = typename Hull<S>::Face;
  using Edge = typename Hull<S>::Edge;

  Core core = Core::point;
  S radius{};    // around the core
  Vec3<S> half;  // segment: (0, 0, h); cylinder: (r, r, h)
  const Hull<S>* topology =
      nullptr;  // loops and edges; for a box those of a box with triangle_faces 2; a cylinder has none
  int own_count = 0;
  std::array<Vec3<S>, 8> own;          // vertices of all polyhedra but hulls
  std::array<Face, 2> triangle_faces;  // triangle: front and back
  std::array<Edge, 3> triangle_edges;  // triangle

  bool polyhedral() const { return core != Core::cylinder; }
  std::span<const Vec3<S>> vertices() const {
    return core == Core::hull ? std::span<const Vec3<S>>(topology->vertices)
                              : std::span<const Vec3<S>>(own.data(), own_count);
  }
  std::span<const Face> faces() const {  // of hulls and triangles alone with their offsets
    if (core == Core::triangle) return triangle_faces;
    return topology ? std::span<const Face>(topology->faces) : std::span<const Face>();
  }
  std::span<const Edge> edges() const {
    if (core == Core::triangle) return triangle_edges;
    return topology ? std::span<const Edge>(topology->edges) : std::span<const Edge>();
  }
  std::span<const int> loop(const Face& face) const {
    return {topology->corners.data() + face.first, static_cast<std::size_t>(face.count)};
  }
};

// False, with `part` unusable, for a hull without vertices and for kinds that are not convex. Kinds as in
// convex_contacts.hpp, and meshes that bound a convex solid.
template <class S> bool convex_part(const Geometry<S>& geometry, ConvexPart<S>& part);
template <class S>
ConvexPart<S> triangle_part(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c, const Vec3<S>& normal);
template <class S> ConvexPart<S> box_part(const Vec3<S>& half_extents);

// The point of the core farthest along `direction` (own axes, of any length) and its vertex; of cylinders the vertex is
// -1. `vertex` on entry: where hill climbing starts.
template <class S> Vec3<S> support(const ConvexPart<S>& part, const Vec3<S>& direction, int& vertex);

// v / |v|, also where v's square would underflow or overflow; 0 for 0.
template <class S> inline Vec3<S> unit_vector(const Vec3<S>& v) {
  const S most = largest_component(v);
  if (!(most > S(0))) return {};
  const Vec3<S> scaled{v.x / most, v.y / most, v.z / most};
  return (S(1) / norm(scaled)) * scaled;
}

// a cross b, each component accurate to an ulp (Kahan's difference of products), so that the normal of nearly parallel
// vectors is accurate.
template <class S> inline Vec3<S> accurate_cross(const Vec3<S>& a, const Vec3<S>& b) {
  const auto difference = [](S p, S q, S r, S s) {  // p q - r s
    const S rs = r * s, error = std::fma(-r, s, rs);
    return std::fma(p, q, -rs) + error;
  };
  return {difference(a.y, b.z, a.z, b.y), difference(a.z, b.x, a.x, b.z), difference(a.x, b.y, a.y, b.x)};
}

// The pose of B in A's frame.
template <class S> Transform<S> relative_transform(const Transform<S>& pose_a, const Transform<S>& pose_b);
// The point x_B of the body, in W.
template <class S> inline Vec3<S> point_to_world(const Transform<S>& pose, const Vec3<S>& x_B) {
  return pose.p_W + to_world(pose, x_B);
}

}  // namespace atwood
