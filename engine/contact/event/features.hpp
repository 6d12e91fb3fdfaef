// Gap functions between a contact feature of one body (a vertex, a sphere or a circle fixed in it) and a facet of
// another body's surface (a face, a line or a point).
//
// While two shapes touch with the same features, the gap is a smooth function of the motion, and contact forces follow
// from its second time derivative (Brogliato, Nonsmooth Mechanics, 2016, ch. 5). A vertex is a sphere of radius 0.
#pragma once

#include <vector>

#include "contact/event/pose.hpp"

namespace atwood::event {

// Body axes; lengths in m.
template <class S> struct ContactFeature {
  Vec3<S> center_B;
  S radius{};
  bool circle = false;   // a circle of that radius about axis_B instead of a sphere; it has gaps to faces only
  bool centered = true;  // center_B is the body's origin
  Vec3<S> axis_B;        // unit
  bool edge = false;     // a straight edge through center_B along axis_B; it has gaps to edges only (edges.hpp)
};

template <class S> struct Facet {
  int dimension = 0;  // 0: a point, 1: a line along direction_B, 2: a face with the outward normal direction_B
  Vec3<S> point_B, direction_B;
};

template <class S> struct FacetTriangle { Vec3<S> corner_B[3], normal_B; };

// The least of the three signed distances [m] of a point to the planes that stand on a triangle's sides; positive
// inside.
template <class S> S depth_inside_triangle(const FacetTriangle<S>& triangle, const Vec3<S>& at_B);

enum class SurfaceKind : unsigned char { plane, point, segment, slab, mesh, edge };

template <class S> struct Surface {
  SurfaceKind kind = SurfaceKind::plane;
  Vec3<S> normal_W;  // plane: n . x = offset with the unit vector n
  S offset{};
  S radius{};            // point: of the sphere about it; segment: of the capsule
  Vec3<S> half_extents;  // slab: of a box, or of a rectangle with z = 0; segment: z only
  std::vector<FacetTriangle<S>> mesh;
  bool flat = false;    // mesh: all triangles lie in one plane
  bool convex = false;  // mesh: of a convex hull, normals outwards
};

// May a sphere touch several facets of the surface at once?
template <class S> bool has_concave_edges(const Surface<S>& surface) {
  return surface.kind == SurfaceKind::mesh && !surface.flat && !surface.convex;
}

// The gap function g [m] of a feature over a facet, its rate g' [m/s], the unit normal n from the surface to the
// feature, the contact point x on the feature, and the rates n' and x'.
template <class S> struct GapKinematics {
  S gap{}, rate{};
  Vec3<S> normal, x;
  Vec3<S> normal_dot, x_dot;  // set by gap_kinematics_with_rates() only
};

// The facet of a slab, segment or mesh nearest to center_B. A vertex (`corner`) has faces only, on the side of
// side_B; `outside_m` is then its distance beyond the face's boundary, else 0.
template <class S>
Facet<S> nearest_facet(const Surface<S>& surface, const Vec3<S>& center_B, bool corner, const Vec3<S>& side_B,
                       S& outside_m);

// Of two unit vectors that are given by quaternions of unit length to round-off: below this sine of their angle a
// circle's axis is parallel to a face's normal, and the centre stands for its lowest point.
template <class S> S tilt_round_off() { return S(256) * real::epsilon<S>(); }
// The point of a circle with the least n_W . x; n_W is a unit vector.
template <class S>
Vec3<S> lowest_point_of_circle(const ContactFeature<S>& feature, const Pose<S>& of, const Vec3<S>& n_W);

// Gap, rate, normal and point of a feature of the body `of` over a facet of the body `on`.
template <class S>
GapKinematics<S> gap_kinematics(const ContactFeature<S>& feature, const Pose<S>& of, const Surface<S>& surface,
                                const Facet<S>& facet, const Pose<S>& on);
// The same with the rates of normal and point.
template <class S>
void gap_kinematics_with_rates(const ContactFeature<S>& feature, const Pose<S>& of, const Surface<S>& surface,
                               const Facet<S>& facet, const Pose<S>& on, GapKinematics<S>& kinematics);
template <class S>
GapKinematics<S> gap_kinematics_with_rates(const ContactFeature<S>& feature, const Pose<S>& of,
                                           const Surface<S>& surface, const Facet<S>& facet, const Pose<S>& on) {
  GapKinematics<S> kinematics;
  gap_kinematics_with_rates(feature, of, surface, facet, on, kinematics);
  return kinematics;
}

}  // namespace atwood::event
