// Active contacts after a segment of a step.
#pragma once

#include "contact/event/run.hpp"

namespace atwood::event {

// At the new states.y: stores the warm start, projects onto the constraints, renews the directions of slip and rolling,
// and drops contacts without a force that have separated. Unsets active.active_set_epoch where the active set must be
// found anew; slip_is_resolved: the segment was short enough to follow a slip to its end.
template <class S>
void maintain_contacts(Bodies<S>& bodies, Proximity<S>& proximity, ActiveSet<S>& active,
                       ConstraintSystem<S>& constraints, StateBuffers<S>& states, bool slip_is_resolved);
// Sets mode slip for a contact and for the other contacts of its pair that are on the friction cone.
template <class S> void release_friction(const Proximity<S>& proximity, ActiveSet<S>& active, Contact<S>& first);

}  // namespace atwood::event
