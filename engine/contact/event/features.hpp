// Smooth gaps: a knob of one body (a ball or a rim fixed in it) against a facet of another (a face, an edge line, a
// point).
//
// Where shapes keep touching with the same features, their gap is a smooth function of the motion; its second
// derivative is what contact forces are solved for. Round shapes are knobs with a radius, corners knobs without.
#pragma once

#include <vector>

#include "math/quat.hpp"
#include "math/vec3.hpp"

namespace atwood::event {

// Where a body is and how it moves; world axes.
template <class S> struct Pose {
  Vec3<S> p, v, w;
  Vec3<S> axis[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};  // the body's, seen from the world
};
template <class S> inline Vec3<S> turned(const Pose<S>& pose, const Vec3<S>& v_B) {
  return v_B.x * pose.axis[0] + v_B.y * pose.axis[1] + v_B.z * pose.axis[2];
}
template <class S> inline Vec3<S> turned_back(const Pose<S>& pose, const Vec3<S>& v_W) {
  return {dot(pose.axis[0], v_W), dot(pose.axis[1], v_W), dot(pose.axis[2], v_W)};
}

template <class S> struct Knob {
  Vec3<S> center_B;
  S radius{};
  bool rim = false;      // a circle of that radius about axis_B, instead of a ball; meets faces alone
  bool centered = true;  // center_B is the body's origin
  Vec3<S> axis_B;
  bool edge = false;  // a straight edge through center_B along axis_B; meets edges alone (edges.hpp)
};

template <class S> struct Facet {
  int dimension = 0;  // 0 a point, 1 a line along direction_B, 2 a face whose outward normal is direction_B
  Vec3<S> point_B, direction_B;
};

template <class S> struct Triangle { Vec3<S> corner_B[3], normal_B; };

// Between the planes through the sides of a triangle, square to it: the least of three signed distances.
template <class S> S within_triangle(const Triangle<S>& triangle, const Vec3<S>& at_B);

enum class SurfaceKind : unsigned char { plane, point, segment, slab, mesh, edge };

template <class S> struct Surface {
  SurfaceKind kind = SurfaceKind::plane;
  Vec3<S> normal_W;  // plane: unit; n . x = offset on it
  S offset{};
  S radius{};            // point (a sphere), segment (a capsule)
  Vec3<S> half_extents;  // slab: a box, or a rectangle with z = 0; segment: z alone
  std::vector<Triangle<S>> mesh;
  bool flat = false;  // mesh: all of its triangles lie in one plane
};

// A knob near a surface. `normal` is a unit vector from the surface to the knob.
template <class S> struct Sight {
  S gap{}, rate{};
  Vec3<S> normal, x;          // x: on the knob, where it is nearest
  Vec3<S> normal_dot, x_dot;  // filled by watch() alone
};

// The facet of a slab, segment or mesh that is nearest to a knob. Corners (radius 0) see faces alone, from the side on
// which `side_B` lies; where they stand beside the face, `beside` is by how much.
template <class S>
Facet<S> nearest_facet(const Surface<S>& surface, const Vec3<S>& center_B, bool corner, const Vec3<S>& side_B,
                       S& beside);

// The point of a rim that lies farthest against the unit vector n.
template <class S> Vec3<S> outermost_of_rim(const Knob<S>& knob, const Pose<S>& of, const Vec3<S>& n_W);

// Gap, rate, normal and point.
template <class S>
Sight<S> look(const Knob<S>& knob, const Pose<S>& of, const Surface<S>& surface, const Facet<S>& facet,
              const Pose<S>& on);
// ... and how normal and point move.
template <class S>
void watch(const Knob<S>& knob, const Pose<S>& of, const Surface<S>& surface, const Facet<S>& facet, const Pose<S>& on,
           Sight<S>& sight);
template <class S>
Sight<S> watch(const Knob<S>& knob, const Pose<S>& of, const Surface<S>& surface, const Facet<S>& facet,
               const Pose<S>& on) {
  Sight<S> sight;
  watch(knob, of, surface, facet, on, sight);
  return sight;
}

}  // namespace atwood::event
