// Projection onto the constraints of lasting contacts.
#pragma once

#include "contact/event/constraints.hpp"

namespace atwood::event {

// Removes drift from states.y: positions along the normals, then velocities by the impulses of least energy. If no
// velocity had to change, the contacts' kinematics are valid at states.y.
template <class S>
void project_contacts(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                      ConstraintSystem<S>& constraints, StateBuffers<S>& states);

}  // namespace atwood::event
