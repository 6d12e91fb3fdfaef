// Where bodies touch, by Bullet's own narrow phase (btCollisionWorld::contactPairTest) and convex casts
// (btContinuousConvexCollision).
//
// Margins: 0 for boxes, cylinders, hulls and triangles (Bullet's default of 0.04 m is a fact of its dynamics; with it a
// hull would be 0.04 m too large); a sphere's or capsule's margin is its radius. Contacts that Bullet reports ahead of
// touching (distance > 0) are left out. Meshes against meshes and planes go through GImpact, against anything else
// through the triangles' bounding-volume tree. A rectangle is a box of zero thickness.
//
// What is Bullet's own: boxes against boxes go by GJK here (its separating-axis test serves the stepped world alone);
// GImpact leaves out a mesh wholly beneath a plane, and finds triangles touching that are apart by its own tolerance.
// Its casts end a millimetre before the touch, whatever the size, and give up after 64 steps.
#pragma once

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::bullet {

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);

}  // namespace atwood::bullet
