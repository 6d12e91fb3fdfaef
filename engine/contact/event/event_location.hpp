// Event location: where in a trial step the first switching function falls through zero (Hairer, Norsett, Wanner,
// Solving Ordinary Differential Equations I, 1993, II.6).
#pragma once

#include "contact/event/run.hpp"

namespace atwood::event {

// Functions that stay positive until the equations of motion change:
//   gap                of a candidate that is not in contact
//   normal_force       of an active contact
//   friction_cone      mu N - |T| of a sticking contact
//   slip_reversal      u . slip_direction of a slipping contact
//   rolling_bound      delta N - |couple| of a contact that holds against rolling
//   rolling_reversal   w . roll_direction of a rolling contact
//   facet              distance of a contact from the boundary of its facet
//   zero_wind          u(0) . u of a body under quadratic drag, u its relative wind
//   reactivation       normal acceleration of a contact that touches without a force
enum class SwitchingFunction : unsigned char {
  none,
  gap,
  normal_force,
  friction_cone,
  slip_reversal,
  rolling_bound,
  rolling_reversal,
  facet,
  zero_wind,
  reactivation
};

template <class S> struct Crossing {
  S theta = S(2);  // in units of the trial step; above 1: none
  SwitchingFunction function = SwitchingFunction::none;
  int index = -1;  // of the candidate, also where it is in contact; of the body under drag
};

// The state after a step of h_s from y into y_new, by the stepper or, for bodies under gravity only, by
// integration.free_flight, which takes the same step. False: an implicit step has no solution.
template <class S>
bool take_step(const ActiveSet<S>& active, Integration<S>& integration, Stepper<S>& stepper, S t_s, S h_s, const S* y,
               S* y_new) {
  if constexpr (has_vector_lanes<S>)
    if (integration.free_flight != nullptr && active.count == 0) {
      integration.free_flight->step(h_s, y, y_new);
      return true;
    }
  return stepper.step(t_s, h_s, y, y_new);
}

// The numerical flow within a trial step: at(theta) is the state after one step of theta h_s from states.y, so that an
// event is as accurate as the method. It overwrites states.y_probe, and whatever an evaluation of rates changes.
template <class S> struct Flow {
  EventRun<S>& run;
  Stepper<S>& stepper;
  S t_s, h_s;
  bool ok = true;  // false: an implicit step had no solution
  S theta_of_probe = S(-1);

  // Reports how a search for the root of an event function ended; `width` is what it leaves undecided, as a share of
  // h_s.
  void report_search(int iterations, S width, bool converged) {
    run.bodies.model.system().solvers.add(
        IterativeSolver::event_location,
        {iterations, static_cast<double>(width), converged ? SolveEnd::converged : SolveEnd::capped});
  }
  const State<S>& at(S theta) {
    StateBuffers<S>& states = run.states;
    if (theta != theta_of_probe)
      ok = take_step(run.active, run.integration, stepper, t_s, theta * h_s, states.y.data(),
                     states.overwrite(states.y_probe)) &&
           ok;
    theta_of_probe = theta;
    return states.y_probe;
  }
};

// Each replaces `first` by an earlier crossing, if it finds one: gaps of near pairs (measured before), switching
// functions of lasting contacts, relative winds.
template <class S> void locate_impact(Flow<S>& flow, Crossing<S>& first);
template <class S> void locate_mode_change(Flow<S>& flow, Crossing<S>& first);
template <class S> void locate_zero_wind(Flow<S>& flow, Crossing<S>& first);
// Looks for bodies that overlap the boundary of a face before `first`. Where the gap of a vertex or of two edges
// explains the overlap, `first` becomes that earlier crossing, and the result is true. False: no gap explains it; the
// run ends, and report.outcome names the bodies.
template <class S> bool check_boundaries(Flow<S>& flow, Crossing<S>& first);
// Does no sphere in contact with a facet of a mesh overlap another facet, up to `first`? False: the run ends, and
// report.outcome says so.
template <class S> bool check_other_facets(Flow<S>& flow, const Crossing<S>& first);

}  // namespace atwood::event
