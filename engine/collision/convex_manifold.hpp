// The points of contact of two convex pieces whose direction of contact is known.
#pragma once

#include "collision/contacts.hpp"
#include "collision/nearest_features.hpp"

namespace atwood {

// In A's axes. `margin` between surfaces. Where a face meets, the other's face, edge or disc is clipped to it and each
// of the points left has its own gap; two parallel edges meet along their common stretch; all else is one point, the
// nearest features' unless meet.gap is infinite (a normal that is not theirs; there may then be no points).
template <class S>
void contact_points(const ConvexPiece<S>& a, const ConvexPiece<S>& b, const Placement<S>& b_in_a, const Meet<S>& meet,
                    S margin, Manifold<S>& manifold);

// Four of the candidates: the deepest, the farthest from it, and those that make the largest quadrilateral.
template <class S>
void keep_four(const std::vector<ContactPoint<S>>& candidates, const Vec3<S>& normal, Manifold<S>& manifold);

}  // namespace atwood
