// Impacts at several contacts at one instant: which contacts are coupled, and the velocities after the impacts.
#pragma once

#include <string>
#include <vector>

#include "dynamics/contacts.hpp"

namespace atwood::dynamics {

// One application of an impact law: to a single pair, or to all contacts of a group in one solve.
template <class S> struct Impact {
  std::vector<ContactPair> pairs;
  std::vector<Impulse<S>> impulses;  // one a pair
  std::vector<S> before;             // y before this impact
};

template <class S> struct ImpactOutcome {
  std::vector<Impact<S>> impacts;  // in the order of their application
  std::string why;                 // not empty: no outcome; continues "the outcome of simultaneous impacts"
  // The outcome depends on a convention that the scene does not state. The motion before this instant is valid.
  bool valid_until_failure = false;
};

// Whether an impulse at one contact changes the normal velocity at the other: they share a mobile body, and
// n_i . n_j != 0 beyond round-off, or either has friction. The impulses of contacts that are not coupled commute.
template <class S>
bool coupled(const Scene& scene, const Layout& layout, const ContactPair& one, const ContactPair& other, const S* y);

// Applies the impact laws to all `contacts` (which touch) that approach faster than their `speed_tolerance` [m/s, one a
// contact], and to the contacts coupled with them; changes the velocities in y. Coupled contacts form groups. A group
// of several is resolved by the scene's convention:
//   sequential   the fastest approach first, ties in the order of the bodies, until none approaches
//   together     0 <= Lambda_i, v_i+ + e_i min(v_i-, 0) >= 0, complementary (J. J. Moreau, Unilateral contact and dry
//                friction in finite freedom dynamics, 1988); without friction, at most 12 contacts
//   unspecified  as sequential, if every order of the contacts and the simultaneous solve agree to round-off; otherwise
//                there is no outcome. At most 4 contacts are tried.
template <class S>
ImpactOutcome<S> resolve_impacts(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& contacts,
                                 const std::vector<S>& speed_tolerance, S* y);

// Applies the law of one Impact to another state y: the map y- to y+, whose derivative gives the saltation matrix.
template <class S>
void reapply_impact(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& pairs, S* y);

}  // namespace atwood::dynamics
