// A contact that shares no moving body with another one.
#pragma once

#include "contact/event/constraints.hpp"

namespace atwood::event {

// Solves for the forces of a decoupled contact, and adds its accelerations to the rates dydt. False: singular; dydt is
// then not finite.
template <class S>
bool add_single_contact_forces(const Bodies<S>& bodies, const Proximity<S>& proximity, Contact<S>& contact, S* dydt);

}  // namespace atwood::event
