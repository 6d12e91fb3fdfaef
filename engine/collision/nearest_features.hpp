// The nearest features of two convex cores: the direction of the gap or of least overlap, computed from the features in
// contact.
#pragma once

#include "collision/contacts.hpp"
#include "collision/expanding_polytope.hpp"

namespace atwood {

template <class S> struct NearestFeatures {
  bool out_of_range = false;  // more than `max_distance` apart: nothing else is set
  S gap{};                    // [m], core to core along the normal; negative: overlap
  Vec3<S> normal;             // unit, from a to b; A's axes
  Vec3<S> on_a, on_b;         // the closest points, or the deepest
  bool faces = false;         // a face touches an edge or a face: on_a, on_b are approximate; use contact_points()
  ConvexSolves solve = {};
};

// By GJK where the cores are apart, by the expanding polytope where they overlap; both then refined from the features
// in contact. `solve` says how each of the two ended.
template <class S>
NearestFeatures<S> nearest_features(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a,
                                    S max_distance);

// Overlap of the cores along a unit direction from a to b.
template <class S>
S overlap_along(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a, const Vec3<S>& n);

// The least overlap of two polyhedra over all normals of faces and all products of two edges: exact, at the cost of a
// support point for each pair of edges. If the cores are apart: minus their distance, unless a vertex is nearest to a
// vertex or an edge.
template <class S>
LeastOverlap<S> least_overlap_of_all_axes(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a);

}  // namespace atwood
