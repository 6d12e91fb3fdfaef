// Flat ends of cylinders on faces and planes.
//
// Where the plane of a circle is that of the face, all of the circle touches, and the lowest point, which is its
// contact, is not unique. The run ends there, unless the contact force passes through the circle's centre (no
// moment tilts the cylinder, and nothing slips): then the centre is taken as the contact point.
#pragma once

#include "contact/event/event_location.hpp"

namespace atwood::event {

// False: at states.y an end lies flat and approaches, or has a contact force; report.outcome says which.
template <class S> bool refuse_flat_ends(EventRun<S>& run, S t_s);
// False: up to `first` an end comes to lie flat, or passes from one side of its circle to the other;
// report.outcome says which.
template <class S> bool check_flat_ends(Flow<S>& flow, const Crossing<S>& first);

}  // namespace atwood::event
