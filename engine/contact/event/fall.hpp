// What ends a step before its time: the first condition to fall of those that must stay positive within it.
#pragma once

#include "contact/event/run.hpp"

namespace atwood::event {

// pressed: a contact that touches and does not carry is pressed on again
enum class Condition : unsigned char { none, gap, force, cone, slip, couple, roll, facet, calm, pressed };

template <class S> struct Fall {
  S theta = S(2);
  Condition condition = Condition::none;
  int index = -1;  // feature, contact or wind
};

// The state after a step of h_s by the run's stepper, or by what does the same for bodies that nothing but gravity
// pulls.
template <class S> bool take_step(EventRun<S>& run, Stepper<S>& stepper, S t_s, S h_s, const S* y, S* y_new) {
  if constexpr (has_vector_lanes<S>)
    if (run.free_flight != nullptr && run.carrying == 0) {
      run.free_flight->step(h_s, y, y_new);
      return true;
    }
  return stepper.step(t_s, h_s, y, y_new);
}

// A run's probe: the state after theta h, from run.y into run.y_probe.
template <class S> struct Flow {
  EventRun<S>& run;
  Stepper<S>& stepper;
  S t_s, h_s;
  bool ok = true;
  S probed = S(-1);  // theta of what stands in run.y_probe

  const S* at(S theta) {
    if (theta != probed) ok = take_step(run, stepper, t_s, theta * h_s, run.y.data(), run.y_probe.data()) && ok;
    probed = theta;
    return run.y_probe.data();
  }
};

template <class S> void earliest_touch(Flow<S>& flow, Fall<S>& first);   // of run.near, whose gaps are measured
template <class S> void earliest_switch(Flow<S>& flow, Fall<S>& first);  // of lasting contacts; sees them
template <class S> void earliest_calm(Flow<S>& flow, Fall<S>& first);    // of winds
// Up to `first`, which becomes the touch of two edges that comes before it. False: some body comes over the end of a
// sheet, with which it has no contact there.
template <class S> bool stays_clear_of_ends(Flow<S>& flow, Fall<S>& first);

}  // namespace atwood::event
