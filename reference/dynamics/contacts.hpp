// Which bodies can touch, how far apart they are, and what an impact does to them: spheres against each other, and
// against planes, rectangles and boxes that are fixed.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/state.hpp"

namespace atwood::dynamics {

struct ContactPair {
  int a = 0, b = 0;  // a < b
  double restitution = 0, friction = 0;
  bool gives = false;  // by a contact law of its own: not rigid
};

struct ContactPairs {
  std::vector<ContactPair> pairs;
  std::string unsupported;  // a pair of shapes that could touch and is not covered, by name; empty when all are
};

// Two bodies with shapes, at least one of them mobile.
bool contacts_possible(const Scene& scene);
// All such pairs that are covered.
ContactPairs contact_pairs(const Scene& scene);
// Is this pair one of those covered?
bool has_gap(const Scene& scene, const ContactPair& pair);
// The body of the pair that is a plane, and the ball beside it; -1: there is no plane.
int plane_of(const Scene& scene, const ContactPair& pair);
int ball_of(const Scene& scene, const ContactPair& pair);

template <class S> struct Gap {
  S gap_m{};                  // negative: overlap
  S rate_m_per_s{};           // d gap / dt: (v_b - v_a) . normal at the centres (spin does not change a sphere's gap)
  std::array<S, 3> normal{};  // unit, from a to b
  std::array<S, 3> x_m{};     // contact point: middle of the closest points
};
template <class S> Gap<S> gap(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y);

// How b's surface slides on a's where they touch: (v_b + w_b x r_b) - (v_a + w_a x r_a) without its part along the
// normal.
template <class S> std::array<S, 3> slip(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y);

// Would friction act on a ball that lies on its plane: does it slide, or is it pulled along (dydt: the rates in y's
// layout)?
template <class S>
bool rubs(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y, const S* dydt, S tiny_m_per_s);

// Why strike() cannot do this pair: it has friction, and a ball whose moments of inertia are not all alike (the slip
// would turn during the impact). Empty when it can.
std::string unstrikable(const Scene& scene, const ContactPair& pair);

template <class S> struct Strike { S normal_N_s{}, tangential_N_s{}; };
// Newton's law with Coulomb friction: changes velocities and rates in y. No effect when the bodies are not approaching.
template <class S> Strike<S> strike(const Scene& scene, const Layout& layout, const ContactPair& pair, S* y);

}  // namespace atwood::dynamics
