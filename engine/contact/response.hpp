// Steps with impacts. Both responses advance the state over one step of the plan's grid, with any stepper inside.
#pragma once

#include <vector>

#include "collision/gap.hpp"
#include "contact/impulse.hpp"
#include "integrators/stepper.hpp"
#include "protocol/sample.hpp"
#include "rigid/model.hpp"

namespace atwood {

// A ball that lies on a plane: its normal motion is gone, what is left is motion along the plane.
struct Resting { int pair = 0; int ball = 0; };

// A body in quadratic drag: |u| u has a kink where u = v - wind vanishes (the top of a vertical bounce).
template <class S> struct Wind { int body = 0; Vec3<S> velocity_W; };

// All that a step with contacts works on; allocated once a run.
template <class S> struct ContactRun {
  RigidModel<S>& model;
  Stepper<S>& stepper;
  std::vector<ContactPair<S>> pairs;
  std::vector<Wind<S>> winds;
  std::vector<Resting> resting;
  std::vector<S> y, y_new, y_try, y_probe, dydt;
  S rtol{}, atol{};              // 0: steps of the grid; else error control inside each of them
  S h_next_s{};                  // what error control would try next
  const Observer* observer = nullptr;
  Outcome outcome;
};

template <class S> ContactRun<S> make_contact_run(RigidModel<S>& model, Stepper<S>& stepper, const Scene& scene, std::string& why);

// Located impacts (`+event`): the step is taken again up to the touch, found to round-off on the method's own flow; then
// the impulse, then the rest of the step. A Zeno end (bounces that pile up in finite time) is summed as the geometric
// series it is, and becomes one `rest` event; from there on the ball lies on the plane.
template <class S> bool step_with_events(ContactRun<S>& run, S t_s, S h_s);

// ---- shared by the two
template <class S> Gap<S> gap_of(const ContactRun<S>& run, const ContactPair<S>& pair, const S* y);
template <class S> S gap_rate(const ContactRun<S>& run, const ContactPair<S>& pair, const S* y);
// The pair's bodies as an impact sees them, and back into the state.
template <class S> void load_impact(const ContactRun<S>& run, const ContactPair<S>& pair, const Gap<S>& gap, const S* y,
                                    ImpactBody<S>& a, ImpactBody<S>& b);
template <class S> void store_impact(const ContactRun<S>& run, const ContactPair<S>& pair, const ImpactBody<S>& a,
                                     const ImpactBody<S>& b, S* y);
template <class S> void report_event(const ContactRun<S>& run, EventKind kind, const ContactPair<S>& pair, const Gap<S>& gap,
                                     const Impulse<S>& impulse, S t_s);
template <class S> bool is_resting(const ContactRun<S>& run, int pair);
// Relative acceleration along the normal, were there no contact: negative presses.
template <class S> S normal_acceleration(ContactRun<S>& run, const ContactPair<S>& pair, S t_s, const S* y);

}  // namespace atwood
