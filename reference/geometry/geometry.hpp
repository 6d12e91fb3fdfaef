// Overlap, penetration depth, distance and first contact of two shapes: the truth for contact queries. In long double,
// by direct comparison of all candidates instead of an iteration for closest points.
//
// - Convex polyhedra, flat polygons and segments, each with a rounding radius (sphere: a point; capsule: a segment):
//   overlapping ones by all separating axes (face normals, cross products of edges), separated ones by all pairs of
//   features (vertex-face, edge-edge). S. Gottschalk, M. C. Lin and D. Manocha (1996) for the axes; C. Ericson,
//   Real-Time
//   Collision Detection (2005), 5.1.9, for segments.
// - Meshes are surfaces: the smallest gap over their triangles; compounds: over their boxes. A closed mesh is a solid:
// any
//   shape inside of it if the mesh is small and convex, otherwise a sphere whose centre is inside (winding number).
// - Cylinders: against spheres and planes.
// - First contact: sphere-sphere and sphere-plane in closed form in quad; other pairs by conservative advancement, with
// a
//   bound from linear and angular velocity for each pair of parts.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "protocol/pair_query.hpp"
#include "protocol/sample_series.hpp"
#include "scene/scene.hpp"

namespace atwood::geometry {

using Real = long double;
using Vector = std::array<Real, 3>;

struct Separation {
  Real gap_m = 0;         // surface to surface; negative: depth along the direction of least penetration
  Vector normal{};        // unit, world axes, from a to b
  Vector on_a{}, on_b{};  // closest or deepest points [m], world axes
  Real bar_m = 0;         // half-width of gap_m: round-off of positions and axes
  Real margin_m = 0;      // difference to the gap along the next direction; 0: the direction is not unique
};

// At the initial pose of the scene, or that of a sample. Throws std::invalid_argument when no_separation gives a
// reason.
Separation separation_between(const Scene& scene, int body_a, int body_b);
Separation separation_between(const Scene& scene, const SampleView& sample, int body_a, int body_b);
// The depth along the direction of least penetration, -gap_m; 0 where the shapes are apart.
Real overlap_depth(const Scene& scene, const SampleView& sample, int body_a, int body_b);
// The pair of shapes that is not covered ("cylinder against box"); empty: it is.
std::string no_separation(const Shape& a, const Shape& b);

// The gap [m] that the rounding of the scene's decimals to double can give two bodies in contact: 0.1 + 0.7 < 0.8.
Real given_round_off(const Scene& scene, int body_a, int body_b);

struct FirstTouch {
  Real t_s = 0, bar_s = 0;  // 0: they overlap at the start
  Vector normal{}, x_m{};   // at that time; the point midway
  bool decided = true;      // false: the iteration ended close to a contact, which may follow after t_s or not
};
// First contact of two bodies in uniform motion with constant angular velocity, within [0, t_end_s]; empty: none.
std::optional<FirstTouch> first_touch(const Scene& scene, int body_a, int body_b, double t_end_s);

// The worker's answer: for each pair of bodies, not both fixed, its deepest point (contact within the bar and the
// rounding of the decimals), or its first contact.
ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);
PairGap pair_gap(const Scene& scene, int body_a, int body_b);

}  // namespace atwood::geometry
