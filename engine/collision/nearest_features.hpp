// How two convex cores lie to each other: the direction of least overlap or of the gap, exact on the features that
// meet.
#pragma once

#include "collision/expanding_polytope.hpp"
#include "protocol/solver_report.hpp"

namespace atwood {

template <class S> struct Meet {
  bool beyond = false;  // more than `enough` apart: nothing else is set
  S gap{};              // core to core along the normal; negative: overlap
  Vec3<S> normal;       // unit, from a to b; A's axes
  Vec3<S> on_a, on_b;   // the closest points, or the deepest
  bool faces = false;   // a face meets an edge or a face: the points are near where they do, the manifold's are exact
  SolveReport solve = {};  // of the direction of least overlap; iterations 0: none was searched for
};

template <class S>
Meet<S> nearest_features(const ConvexPiece<S>& a, const ConvexPiece<S>& b, const Placement<S>& b_in_a, S enough);

// Overlap of the cores along a unit direction from a to b.
template <class S>
S overlap_along(const ConvexPiece<S>& a, const ConvexPiece<S>& b, const Placement<S>& b_in_a, const Vec3<S>& n);

// The least overlap of two polyhedra over every normal of a face and every product of two edges: exact, and slow for
// large ones (as many supports as pairs of edges). The cores apart: their distance, when no vertex is nearest to a
// vertex or edge.
template <class S>
LeastOverlap<S> least_overlap_of_all_axes(const ConvexPiece<S>& a, const ConvexPiece<S>& b, const Placement<S>& b_in_a);

}  // namespace atwood
