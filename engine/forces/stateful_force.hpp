// A force with internal state: friction springs, histories of contacts.
#pragma once

#include "forces/force.hpp"
#include "protocol/sample.hpp"

namespace atwood {

// Within a step its loads depend on the motion and on the internal state alone; the internal state changes only when a
// step is accepted, so rejected steps and the stages of a step do not change it.
template <class S> class StatefulForce : public ForceTerm<S> {
 public:
  // The start of a run, at its first motion: the internal state is cleared.
  virtual void reset(const Motion<S>& motion) = 0;
  // For adaptive steps, which would otherwise pass over a contact that begins and ends within them. The longest step
  // from this motion, at most `step_s`, in which bodies that are apart do not touch and part again; `acceleration_W` of
  // each body.
  virtual S longest_step(const Motion<S>&, const std::vector<Vec3<S>>& /*acceleration_W*/, S step_s) { return step_s; }
  // After a step of `step_s` from there that ended in this motion: `step_s`, or the time to the middle of a contact
  // that has begun and ended within it.
  virtual S missed_contact(const Motion<S>&, S step_s) { return step_s; }
  // A step was accepted and ended in this motion. Returns true if the loads at this motion changed with the internal
  // state: rates that were evaluated before must be evaluated again.
  virtual bool accept_step(const Motion<S>& motion) = 0;
  // At an output time: the contacts that carry load go to sample.contacts, the events since the last output time to
  // observer.event.
  virtual void report(const Motion<S>& motion, Sample& sample, const Observer& observer) = 0;
};

}  // namespace atwood
