// Contacts by ODE's dCollide, geom against geom. Its trimesh code computes in float in every build. A
// rectangle is a box of zero thickness; a hull is dConvex. ODE has no sweeps.
//
// Properties of ODE: a dConvex completely below a plane is not found; box against box prefers faces to edges by a
// factor of 1.05; a capsule with its axis inside a box is treated as a sphere; spheres and capsules against dConvex use
// libccd, with its absolute tolerances.
#pragma once

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::ode {

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);

}  // namespace atwood::ode
