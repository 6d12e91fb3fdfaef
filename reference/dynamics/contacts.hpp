// Contact pairs, their gap functions and their impact law: spheres against each other, and against planes, rectangles
// and boxes that are fixed.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/state.hpp"

namespace atwood::dynamics {

struct ContactPair {
  int a = 0, b = 0;  // indices of the bodies, a < b
  double restitution = 0, friction = 0;
  bool compliant = false;  // the pair has a compliant contact law (linear or Hertz); otherwise it is rigid
};

struct ContactPairs {
  std::vector<ContactPair> pairs;
  std::string unsupported;  // names a pair that could touch and has no gap function here; empty when all have one
};

// Two bodies with shapes, at least one of them mobile.
bool contacts_possible(const Scene& scene);
// All pairs that can touch and have a gap function.
ContactPairs contact_pairs(const Scene& scene);
// Is there a gap function for this pair?
bool has_gap(const Scene& scene, const ContactPair& pair);
// The body of the pair that is a plane, and the sphere beside it; -1: neither body is a plane.
int plane_of(const Scene& scene, const ContactPair& pair);
int ball_of(const Scene& scene, const ContactPair& pair);

template <class S> struct Gap {
  S gap_m{};                  // negative: overlap
  S rate_m_per_s{};           // d gap / dt: (v_b - v_a) . normal at the centres (spin does not change a sphere's gap)
  std::array<S, 3> normal{};  // unit, from a to b
  std::array<S, 3> x_m{};     // contact point: middle of the closest points
};
// The pair must have a gap function (has_gap).
template <class S> Gap<S> gap(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y);

// Slip velocity at the contact [m/s]: (v_b + w_b x r_b) - (v_a + w_a x r_a) without its normal component.
template <class S> std::array<S, 3> slip(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y);

// Does friction act on a sphere that lies on its plane? It does when the sphere slips, or accelerates along the plane,
// by more than `tiny_m_per_s` (dydt: the rates in y's layout). False for pairs without a plane.
template <class S>
bool friction_acts(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y, const S* dydt,
                   S tiny_m_per_s);

// Why apply_impact_law() does not cover this pair: it has friction, and a body with different principal moments of
// inertia (the slip direction would turn during the impact). Empty when it covers the pair.
std::string impact_unsupported(const Scene& scene, const ContactPair& pair);

template <class S> struct Impulse { S normal_N_s{}, tangential_N_s{}; };
// Newton's impact law with Coulomb friction: changes the velocities and angular velocities in y. Zero impulse when the
// bodies do not approach.
template <class S> Impulse<S> apply_impact_law(const Scene& scene, const Layout& layout, const ContactPair& pair, S* y);

}  // namespace atwood::dynamics
