// The contact points of two convex pieces whose contact normal is known.
#pragma once

#include "collision/contacts.hpp"
#include "collision/nearest_features.hpp"

namespace atwood {

// In A's axes; points whose surfaces are more than `margin` apart are left out. A face in contact: the other's face,
// edge or disc is clipped to it (Sutherland, Hodgman 1974). Parallel edges: the ends of their common stretch. Otherwise
// the nearest features' point; none if features.gap is infinite (the normal was given, not computed) and nothing
// overlaps.
template <class S>
void contact_points(const ConvexPiece<S>& a, const ConvexPiece<S>& b, const Placement<S>& b_in_a,
                    const NearestFeatures<S>& features, S margin, Manifold<S>& manifold);

// Reduces the candidates to four: the deepest, the farthest from it, and one on each side with the largest area.
template <class S>
void keep_four(const std::vector<ContactPoint<S>>& candidates, const Vec3<S>& normal, Manifold<S>& manifold);

}  // namespace atwood
