// Narrow phase: where two shapes touch.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "collision/geometry.hpp"
#include "protocol/solver_report.hpp"

namespace atwood {

template <class S> struct ContactPoint {
  Vec3<S> x_W;           // [m], midway between the two surfaces along the normal
  S gap{};               // [m], surface to surface along the normal; negative: overlap
  std::uint32_t id = 0;  // of the pair of features in contact: constant while they touch (for warm starting)
};

// How the iterations for a pair of convex parts ended; iterations 0: there was none.
struct ConvexSolves {
  SolveReport closest_points = {};  // GJK
  SolveReport least_overlap = {};   // the direction of least overlap
  bool capped() const { return closest_points.ended == SolveEnd::capped || least_overlap.ended == SolveEnd::capped; }
};
// Counts the searches for the direction of least overlap, and of GJK's those that were capped: it runs for every pair
// that is near, and nearly always ends at its tolerance.
inline void add_convex_solves(const ConvexSolves& solves, SolverTallies& tallies) {
  if (solves.least_overlap.iterations > 0) tallies.add(IterativeSolver::expanding_polytope, solves.least_overlap);
  if (solves.closest_points.ended == SolveEnd::capped)
    tallies.add(IterativeSolver::closest_points, solves.closest_points);
}

// The shape of the contact region: one point, a segment, the crossing of two edges, a polygon.
enum class ManifoldType : unsigned char { point, edge, edge_edge, face };

// The contact manifold of two convex parts: one normal and at most four points of the clipped polygon, reduced to the
// deepest one and those that span the largest area.
template <class S> struct Manifold {
  Vec3<S> normal_W;  // unit, from a to b
  ManifoldType type = ManifoldType::point;
  int count = 0;
  std::array<ContactPoint<S>, 4> points;
  int part_a = 0, part_b = 0;  // which box of a compound, which triangle of a mesh
  ConvexSolves solve = {};
};

// Appends the manifolds of a and b whose surfaces come within `margin` of each other (0: touching or overlapping), in
// an order that depends on the shapes alone. Convex pairs: at most one; compounds and meshes: one for each pair of
// parts. Swapping a and b flips the normals and nothing else. Overlap is measured along the direction of least
// penetration. Sources: Ericson, Real-Time Collision Detection (2005), ch. 5; Gottschalk, Lin, Manocha (1996) for the
// 15 axes.
template <class S>
void find_contacts(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b, const Transform<S>& pose_b,
                   S margin, std::vector<Manifold<S>>& out);

// Null when this pair of kinds has a test; else what is missing ("plane against plane", "mesh against ...").
const char* missing_contact_test(ShapeKind a, ShapeKind b);

// The gap [m] that rounding alone may leave between surfaces that touch: rounding of the given positions and of the
// computation. Spheres of radius 0.1 and 0.7 whose centres are 0.8 apart touch, although these doubles leave 8e-17
// between them.
template <class S>
S touch_round_off(const Geometry<S>& a, const Vec3<S>& p_a, const Geometry<S>& b, const Vec3<S>& p_b);

// ---- closest features ---------------------------------------------------------------------------------------------
template <class S> struct Separation {
  S gap{};                 // signed: negative is the depth of least penetration
  Vec3<S> normal_W;        // unit, from a to b
  Vec3<S> on_a_W, on_b_W;  // the closest points, or the deepest points in overlap
  ConvexSolves solve = {};
};
// Of shapes that touch the gap is 0 up to touch_round_off(). A pair of kinds without a test (missing_contact_test())
// has an infinite gap.
template <class S>
Separation<S> separation(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b,
                         const Transform<S>& pose_b);

}  // namespace atwood
