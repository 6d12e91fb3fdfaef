// The direction of least overlap of two convex cores.
#pragma once

#include "collision/gjk.hpp"

namespace atwood {

// Overlap along a unit n from a to b: max over a of n . x less min over b of n . x. Its least over all n is the depth;
// below zero the cores are apart.
template <class S> struct LeastOverlap {
  Vec3<S> normal{S(0), S(0), S(1)};
  S overlap{};    // along `normal`, by supports: never below the least
  S certified{};  // the least is no smaller (a face of a polytope within A - B); -infinity when A - B has no volume
  Vec3<S> on_a, on_b;  // deepest points, A's axes
  Simplex<S> face;     // of A - B, that the normal belongs to
  int points = 0;      // of A - B beyond the first four that the polytope took in
};

// The expanding polytope (van den Bergen 2001), from any tetrahedron in A - B: while the origin is outside, its
// distances to faces that see it are negative and such faces grow first. No allocation.
template <class S>
LeastOverlap<S> expanding_polytope(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a);

}  // namespace atwood
