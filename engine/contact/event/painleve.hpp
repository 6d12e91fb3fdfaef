// Configurations without a contact force, or with several (Painleve 1895).
#pragma once

#include "contact/event/constraints.hpp"

namespace atwood::event {

// True if the forces found are the only solution. False: there are several; the run ends. If there is no solution, sets
// active.inconsistent to the pair, for impact_without_collision(), and returns true. Below tiny_acceleration [m/s^2]
// and tiny_N values are round-off.
template <class S> bool check_forces(EventRun<S>& run, S t_s, S tiny_acceleration, S tiny_N);
// The impact without collision of active.inconsistent, with all impacts that follow. False: it has no answer, and the
// run ends.
template <class S> bool impact_without_collision(EventRun<S>& run, S t_s);

// The normal acceleration per 1 N of a contact with its friction (a Delassus element) vanishes where forces become
// unbounded. Its range and that of the normal force are recorded over the evaluations of a trial step.
template <class S> void record_delassus(Contact<S>& contact, S delassus, S normal_N);
template <class S> void reset_delassus_range(ActiveSet<S>& active);
// False: some element vanishes, or is small and the method cannot follow: the element changes too much, or the normal
// force became negative by more than it was positive. The step must be shorter.
template <class S>
bool delassus_is_resolved(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active);
// True where some contact's Delassus element is near zero at the present state.
template <class S>
bool near_singularity(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active);

}  // namespace atwood::event
