// Length of the segments of a step while contacts slip.
#pragma once

#include "contact/event/constraints.hpp"

namespace atwood::event {

// True where the contact slips with a speed that is zero up to round-off; it keeps the direction of its onset.
template <class S> bool slip_is_zero(const Bodies<S>& bodies, const Contact<S>& contact) {
  return contact.mode == FrictionMode::slip && !(contact.slip_speed > bodies.slip_round_off());
}

// The length of the next segment of a step of h_s of which left_s is left, at most left_s. Decides about the fine
// stepper (integration.use_fine_stepper) and about contacts that keep their slip direction (Contact::slip_onset).
template <class S> S slip_limited_step(EventRun<S>& run, S t_s, S h_s, S left_s);

}  // namespace atwood::event
