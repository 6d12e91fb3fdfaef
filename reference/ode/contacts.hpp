// Where bodies touch, by ODE's dCollide, geom against geom. Its trimesh code is float inside, whatever the build. A
// rectangle is a box of zero thickness; a hull is dConvex. ODE has no sweeps.
//
// What is ODE's own: dConvex wholly beneath a plane is not found; box against box prefers faces to edges by its factor
// of 1.05; a capsule whose axis is inside a box is answered as a ball; spheres and capsules against dConvex go to
// libccd, with its numbers without a unit.
#pragma once

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::ode {

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);

}  // namespace atwood::ode
