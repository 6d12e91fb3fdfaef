// Contacts of convex shapes by their support functions: sphere, rectangle, box, capsule, cylinder, convex, in any pair;
// and polyhedra against planes.
//
// A shape is a core and a radius around it: a sphere's core is a point, a capsule's a segment. Cores apart: Gilbert,
// Johnson, Keerthi (1988) in the signed-volumes form of Montanari, Petrinic, Barbieri (2017). Cores that overlap: the
// expanding polytope (van den Bergen 2001). Either way the normal is then computed from the features in contact (a
// face's normal, the product of two edges, a rim), so that gap and normal are accurate to a few ulp of the extents.
#pragma once

#include <vector>

#include "collision/contacts.hpp"

namespace atwood {

// As find_contacts and separation; neither kind is plane or compound, and of meshes they take those that bound a convex
// solid.
template <class S>
void convex_contacts(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b, const Transform<S>& pose_b,
                     S margin, std::vector<Manifold<S>>& out);
template <class S>
Separation<S> convex_separation(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b,
                                const Transform<S>& pose_b);

// A plane (first) and a convex polyhedron (kind `convex`): the normal is the plane's, from it into the hull when that
// lies above.
template <class S>
void hull_plane_contacts(const Geometry<S>& plane, const Geometry<S>& hull, const Transform<S>& pose_hull, S margin,
                         std::vector<Manifold<S>>& out);
template <class S>
Separation<S> hull_plane_separation(const Geometry<S>& plane, const Geometry<S>& hull, const Transform<S>& pose_hull);

}  // namespace atwood
