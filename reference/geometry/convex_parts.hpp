// Shapes as convex parts with a rounding radius, planes and cylinders. Private to this room.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "geometry/geometry.hpp"

namespace atwood::geometry {

inline constexpr Real kUnit = std::numeric_limits<Real>::epsilon() / 2;

inline Vector widened(const Real3& v) { return {v[0], v[1], v[2]}; }
inline std::array<Real, 4> widened(const Real4& q) { return {q[0], q[1], q[2], q[3]}; }

inline Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector operator*(Real s, const Vector& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Real dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Real norm(const Vector& a) { return std::hypot(a[0], a[1], a[2]); }

// The pose of a body.
struct Pose {
  Vector p_W{};
  std::array<Vector, 3> axis_W{Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}};  // the columns of R_WB
};
Pose pose_of(const Vector& p_WB, const std::array<Real, 4>& q_WB);
inline Vector to_world(const Pose& pose, const Vector& v) {
  return v[0] * pose.axis_W[0] + v[1] * pose.axis_W[1] + v[2] * pose.axis_W[2];
}

// A convex polyhedron, polygon, segment or point, enlarged by radius_m. World axes [m].
struct ConvexPart {
  int dimension = 3;  // 0 point, 1 segment, 2 polygon, 3 solid
  std::vector<Vector> vertices;
  struct Face {
    Vector normal;
    std::vector<int> corners;
    Real sharpness = 1;
  };                        // sharpness: height over length of a triangle;
                            // round-off of its normal is divided by it
  std::vector<Face> faces;  // a polygon has one; triangles of one face of a hull may overlap
  std::vector<std::array<int, 2>> edges;
  Real radius_m = 0;
};
std::vector<ConvexPart> convex_parts_of(const Shape& shape, const Pose& pose);

// a cylinder
struct RoundBar {
  Vector centre, axis;
  Real radius_m = 0, half_length_m = 0;
};
// Unit normal, out of the half-space.
struct HalfSpace {
  Vector normal;
  Real offset_m = 0;
};

// ---- separations of one part -------------------------------------------------------------------------------------
// What is asked of shapes that are apart: their gap and closest points, or only that they are, by a bound of the gap.
enum class Gap { exact, of_overlap };
Separation separation(const ConvexPart& a, const ConvexPart& b, Gap wanted = Gap::exact);
Separation above(const ConvexPart& a, const HalfSpace& plane);  // normal from a to the plane
Separation above(const RoundBar& a, const HalfSpace& plane);
Separation from_ball(const Vector& centre, Real radius_m, const RoundBar& b);

// The same for two bodies at given poses.
Separation separation(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Gap wanted = Gap::exact);

}  // namespace atwood::geometry
