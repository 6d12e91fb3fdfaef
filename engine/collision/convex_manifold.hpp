// The contact points of two convex parts whose contact normal is known.
#pragma once

#include "collision/contacts.hpp"
#include "collision/nearest_features.hpp"

namespace atwood {

// At most four contact points, in A's axes. Where a face is perpendicular to the normal, the other part's face, edge
// or disc is clipped to it (Sutherland, Hodgman 1974); parallel edges have the ends of their common part; otherwise the
// point of the nearest features is the only one. Points at which the surfaces are more than `margin` apart are left
// out. manifold.count is 0 if the normal was given instead of computed (features.gap is infinite) and nothing overlaps.
template <class S>
void contact_points(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a,
                    const NearestFeatures<S>& features, S margin, Manifold<S>& manifold);

// Reduces the candidates to four: the deepest, the farthest from it, and one on each side with the largest area. The
// type of the manifold follows from their number.
template <class S>
void keep_four(const std::vector<ContactPoint<S>>& candidates, const Vec3<S>& normal, Manifold<S>& manifold);

}  // namespace atwood
