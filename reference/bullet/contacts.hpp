// Where bodies touch, by Bullet's own narrow phase and convex casts (btContinuousConvexCollision). The narrow phase has two
// tables of algorithms, and both are offered:
//   contacts         the stepped world's (BT_CONTACT_POINT_ALGORITHMS): what a step of a new pair gets, as
//                    btCollisionDispatcher's near callback asks for it. Boxes go by the separating-axis test
//   closest-points   btCollisionWorld::contactPairTest's (BT_CLOSEST_POINT_ALGORITHMS). Boxes go by GJK and, overlapping, by
//                    EPA
//
// Margins: 0 for boxes, cylinders, hulls and triangles (Bullet's default of 0.04 m is a fact of its dynamics; with it a
// hull would be 0.04 m too large); a sphere's or capsule's margin is its radius. Contacts that Bullet reports ahead of
// touching (distance > 0) are left out. Meshes against meshes and planes go through GImpact, against anything else
// through the triangles' bounding-volume tree. A rectangle is a box of zero thickness.
//
// A persistent manifold gathers points over several steps; reported here are the points of one call. Bullet's own
// behaviour is kept: GImpact leaves out a mesh wholly beneath a plane, and reports triangles as touching that are apart by
// less than its tolerance. Its casts end a millimetre before the touch, whatever the size, and give up after 64 steps.
#pragma once

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::bullet {

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);   // as the world steps
ContactAnswer closest_points(const Scene& scene, const ContactQuery& query);  // as contactPairTest answers

}  // namespace atwood::bullet
