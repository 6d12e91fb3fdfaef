// Mass, centroid and inertia of solid shapes of uniform density.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood {

// About the centre of mass, in body axes. A flat plate has no volume but an inertia.
struct MassProperties {
  double volume_m3 = 0;
  Real33 inertia_per_kg_m2{};
};

// Fills `out`; returns what forbids it ("has its centroid at ...; expected ..."), or nothing.
std::string mass_properties(const Shape& shape, MassProperties& out);

// What no rigid body can have: not symmetric, a principal moment of 0 or less, one above the sum of the others.
std::string inertia_problem(const Real33& inertia_kg_m2);

// A symmetric matrix = axes diag(moments) axes^T; the columns of `axes` (row-major) are a right-handed frame of unit
// vectors. A diagonal matrix keeps its order and its bits, with the identity as axes.
struct Diagonalised {
  Real3 moments{};
  Real33 axes{};
};
Diagonalised diagonalise(const Real33& symmetric);

// Triangles of the hull, anticlockwise from outside; empty when the points are (nearly) flat.
std::vector<std::array<int, 3>> convex_hull(const std::vector<Real3>& points);

}  // namespace atwood
