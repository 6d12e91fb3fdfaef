// Flat ends of cylinders on faces and planes.
//
// Where the plane of a circle is that of the face, all of the circle touches, and the lowest point, which is its
// contact, is not unique. The run ends there, unless the whole contact force passes through the circle's centre:
// nothing turns the cylinder over, and friction, if there is any, acts on no slip. Then the centre stands for all
// points.
#pragma once

#include "contact/event/event_location.hpp"

namespace atwood::event {

// False: at states.y an end lies flat and approaches, or has a contact force; report.outcome says which.
template <class S> bool refuse_flat_ends(EventRun<S>& run, S t_s);
// False: up to `first` an end comes to lie flat, or passes from one side of its circle to the other;
// report.outcome says which.
template <class S> bool check_flat_ends(Flow<S>& flow, const Crossing<S>& first);

}  // namespace atwood::event
