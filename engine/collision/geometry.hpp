// Collision geometry: shapes prepared once a run, in body axes [m], in the engine's scalar.
#pragma once

#include <memory>
#include <vector>

#include "math/quat.hpp"
#include "math/vec3.hpp"
#include "scene/scene.hpp"

namespace atwood {

// The pose of a body B in the frame W, the world or another body: its centre [m] and its axes (the columns of R_WB).
template <class S> struct Transform {
  Vec3<S> p_W;
  Vec3<S> axis_W[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};
};
template <class S> Transform<S> transform(const Vec3<S>& p_WB, const Quat<S>& q_WB);
// R_WB v and R_WB^T v, the same direction in the axes of W and of B.
template <class S> inline Vec3<S> to_world(const Transform<S>& pose, const Vec3<S>& v_B) {
  return v_B.x * pose.axis_W[0] + v_B.y * pose.axis_W[1] + v_B.z * pose.axis_W[2];
}
template <class S> inline Vec3<S> to_body(const Transform<S>& pose, const Vec3<S>& v_W) {
  return {dot(pose.axis_W[0], v_W), dot(pose.axis_W[1], v_W), dot(pose.axis_W[2], v_W)};
}

// In the order of the alternatives of Shape (scene/scene.hpp).
enum class ShapeKind : unsigned char { none, sphere, plane, rectangle, box, capsule, cylinder, convex, mesh, compound };

template <class S> struct Hull;          // vertices, faces, edges of a convex polyhedron (hull.hpp)
template <class S> struct TriangleMesh;  // triangles, adjacency and a bounding-volume tree (triangle_mesh.hpp)

template <class S> struct Geometry {
  ShapeKind kind = ShapeKind::none;
  Vec3<S> half_extents{};     // box; rectangle: z = 0
  S radius{}, half_length{};  // sphere, capsule, cylinder
  Vec3<S> normal_W{};         // plane: unit
  S offset{};                 // plane: n . x = offset on it, divided by the given normal's length
  S bounding_radius{};        // about the body's origin; infinite for planes
  std::shared_ptr<const Hull<S>> hull;
  std::shared_ptr<const TriangleMesh<S>> mesh;
  struct Part {
    Vec3<S> half_extents, p_B;
    Quat<S> q_BP;
  };
  std::vector<Part> parts;  // compound: oriented boxes
};
template <class S> Geometry<S> make_geometry(const Shape& shape);
// The pose of a compound's box when its body's pose is `body`.
template <class S> Transform<S> part_transform(const Transform<S>& body, const typename Geometry<S>::Part& part);

template <class S> struct Aabb { Vec3<S> low, high; };
// The tight box around the shape in world axes (planes: infinite).
template <class S> Aabb<S> bounds(const Geometry<S>& geometry, const Transform<S>& pose);

}  // namespace atwood
