// Where two shapes touch, how deep or how far apart they are, and when they first meet: the truth that contact queries
// are held against. Long double throughout, code of its own: no closest-point iteration, but every candidate compared.
//
// - Convex polyhedra, flat polygons and segments, each with a rounding radius (sphere: a point; capsule: a segment):
// overlap by
//   all separating axes (face normals, edge crosses), apart by all pairs of features (vertex-face, edge-edge).
//   Gottschalk, Lin, Manocha (1996) for the axes; Ericson, Real-Time Collision Detection (2005), 5.1.9 for segments.
// - Meshes are surfaces: the smallest gap over their triangles. Compounds likewise over their boxes. But a closed mesh
// is a
//   solid: if it is small and convex to everything, else to a sphere whose centre is inside (by winding number).
// - Cylinders: against spheres and planes.
// - First touch: sphere-sphere and sphere-plane by formula in quad; the rest by advancing time while no motion allowed
// by speed
//   and spin can close the gap of any two parts.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "protocol/pair_query.hpp"
#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::geometry {

using Real = long double;
using Vector = std::array<Real, 3>;

struct Separation {
  Real gap_m = 0;         // surface to surface; negative: depth along the direction of least penetration
  Vector normal{};        // unit, world axes, from a to b
  Vector on_a{}, on_b{};  // closest or deepest points [m], world axes
  Real bar_m = 0;         // half-width of gap_m: round-off of positions and axes
  Real margin_m = 0;      // by how much the next direction's gap is smaller; 0 where the direction is not unique
};

// At the scene's initial pose, or at a sample's. Throws std::invalid_argument where no_separation says why.
Separation separation_between(const Scene& scene, int body_a, int body_b);
Separation separation_between(const Scene& scene, const Sample& sample, int body_a, int body_b);
// What it has no truth for ("cylinder against box"), empty when it has one.
std::string no_separation(const Shape& a, const Shape& b);

// How far apart two bodies that touch may be by the rounding of the scene's decimals to double: 0.1 + 0.7 is less than
// 0.8.
Real given_round_off(const Scene& scene, int body_a, int body_b);

struct FirstTouch {
  Real t_s = 0, bar_s = 0;  // 0: they overlap at the start
  Vector normal{}, x_m{};   // at that time; the point midway
  bool decided = true;      // false: near each other for very many steps; they may touch after t_s or not at all
};
// Of two bodies on straight lines with constant spin, within [0, t_end_s].
std::optional<FirstTouch> first_touch(const Scene& scene, int body_a, int body_b, double t_end_s);

// What the worker answers: of each pair not both fixed its deepest point (touching within the bar and the decimals'
// rounding counts), or first touch.
ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);
PairGap pair_gap(const Scene& scene, int body_a, int body_b);

}  // namespace atwood::geometry
