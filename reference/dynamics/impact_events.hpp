// What every integration with located impacts needs besides the impact law: events, refusals, and a check of progress.
#pragma once

#include <string>
#include <vector>

#include "dynamics/simultaneous.hpp"
#include "protocol/sample.hpp"

namespace atwood::dynamics {

// An event of the pair at t_s, with the point and the normal of its gap; impulses and speeds are zero.
template <class S> Event event_at(S t_s, EventKind kind, const ContactPair& pair, const Gap<S>& where);

// Appends one impact event for each pair with an impulse; `after` is y after the impact.
template <class S>
void append_impacts(const Scene& scene, const Layout& layout, const Impact<S>& impact, const S* after, S t_s,
                    std::vector<Event>& events);

// Why an impact of the pair at (t, y) cannot be resolved; empty: it can. `held` are pairs of a plane and a ball at
// rest.
struct ImpactRefusal {
  std::string why;                   // a sentence
  bool valid_until_failure = false;  // the motion before t is valid
};
template <class S>
ImpactRefusal impact_refusal(const Scene& scene, const Layout& layout, const ContactPair& pair,
                             const std::vector<ContactPair>& held, S t_s, const S* y);

// Counts the impacts in a row between which the time does not advance by a unit in its last place.
template <class S> class ImpactProgress {
 public:
  // Counts an impact at t_s >= 0. False: there were more than a thousand such impacts in a row.
  bool advances(S t_s);
  // What to say then.
  static std::string failure(S t_s);

 private:
  S last_impact_s_ = -1;
  int stalled_ = 0;
};

}  // namespace atwood::dynamics
