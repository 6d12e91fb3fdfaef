// Contacts by Bullet's narrow phase and convex casts (btContinuousConvexCollision). The narrow phase has two tables of
// algorithms, and both are available:
//   contacts         the stepped world's (BT_CONTACT_POINT_ALGORITHMS): what a step of a new pair gets, as
//                    btCollisionDispatcher's near callback asks for it. Boxes: separating-axis test
//   closest-points   btCollisionWorld::contactPairTest's (BT_CLOSEST_POINT_ALGORITHMS). Boxes: GJK and, when
//                    overlapping, EPA
//
// Margins: 0 for boxes, cylinders, hulls and triangles (in its dynamics boxes and cylinders have Bullet's default of
// 0.04 m or less, inside); a sphere's or capsule's margin is its radius. Contacts that Bullet reports before
// touching (distance > 0) are left out. Meshes against meshes and planes use GImpact, against other shapes the
// bounding- volume tree of the triangles. A rectangle is a box of zero thickness.
//
// A persistent manifold gathers points over several steps; reported here are the points of one call. Bullet's
// behaviour is kept: GImpact does not report a mesh completely below a plane, and reports triangles that are separated
// by less than its tolerance. Its casts end a millimetre before the contact at any size of the bodies, or after 64
// steps.
#pragma once

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::bullet {

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);   // as the world steps
ContactAnswer closest_points(const Scene& scene, const ContactQuery& query);  // as contactPairTest answers

}  // namespace atwood::bullet
