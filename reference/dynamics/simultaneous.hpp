// Several contacts that are struck at one instant: which of them belong together, and what they leave behind.
#pragma once

#include <string>
#include <vector>

#include "dynamics/contacts.hpp"

namespace atwood::dynamics {

// One application of a law of impact: a single pair, or all contacts of a group in one solve. `pairs` index into the
// contacts that were given, one impulse each; `before` is the state that it acted on.
template <class S> struct Blow {
  std::vector<ContactPair> pairs;
  std::vector<Strike<S>> impulses;
  std::vector<S> before;
};

template <class S> struct Resolved {
  std::vector<Blow<S>> blows;
  std::string why;      // not empty: not resolved, in words that follow "the outcome of simultaneous impacts"
  bool branch = false;  // the laws are known and the outcome is not: it hangs on a convention that the scene lacks
};

// Do impulses at the two contacts act on each other: a mobile body in common, and n_i . n_j != 0 beyond round-off or
// friction at either? Impulses that do not act on each other commute.
template <class S>
bool couple(const Scene& scene, const Layout& layout, const ContactPair& one, const ContactPair& other, const S* y);

// Strikes all of `touching` that approach faster than `slow` [m/s, one a contact], and what they drive together.
// Contacts that couple form groups. A group of several is resolved by the scene's convention:
//   sequential   the fastest approach first, ties in the order of the bodies, until none approaches
//   together     0 <= Lambda_i, v_i+ + e_i min(v_i-, 0) >= 0, one of them 0 (J. J. Moreau, Unilateral contact and dry
//                friction in finite freedom dynamics, 1988); without friction, at most 12 contacts
//   unspecified  as if sequential, when every order of the contacts and the solve for all together agree to round-off;
//                else a branch. At most 4 contacts are tried.
template <class S>
Resolved<S> strike_all(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& touching,
                       const std::vector<S>& slow, S* y);

// The map y- to y+ of one Blow; its derivative gives the saltation matrix.
template <class S>
void strike_again(const Scene& scene, const Layout& layout, const std::vector<ContactPair>& pairs, S* y);

}  // namespace atwood::dynamics
