// Where bodies touch, by ODE's dCollide, geom against geom. Its trimesh code is float inside, whatever the build. A rectangle
// is a box of zero thickness; a hull is dConvex. ODE has no sweeps.
#pragma once

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::ode {

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);

}  // namespace atwood::ode
