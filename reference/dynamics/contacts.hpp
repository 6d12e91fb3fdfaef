// Which bodies can touch, how far apart they are, and what an impact without friction does to them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/state.hpp"

namespace atwood::dynamics {

struct ContactPair {
  int a = 0, b = 0;      // a < b
  double restitution = 0, friction = 0;
};

struct ContactPairs {
  std::vector<ContactPair> pairs;
  std::string unsupported;  // a pair of shapes that could touch and is not covered, by name; empty when all are
};

// Pairs of bodies with shapes, at least one of them mobile. Covered: sphere-sphere and sphere-plane.
ContactPairs contact_pairs(const Scene& scene);
// Is this pair one of those covered?
bool has_gap(const Scene& scene, const ContactPair& pair);

template <class S>
struct Gap {
  S gap_m{};                  // negative: overlap
  S rate_m_per_s{};           // d gap / dt: (v_b - v_a) . normal at the centres (spin does not change a sphere's gap)
  std::array<S, 3> normal{};  // unit, from a to b
  std::array<S, 3> x_m{};     // contact point: middle of the closest points
};
template <class S>
Gap<S> gap(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y);

// Newton's law without friction: changes the velocities in y, returns the normal impulse [N s]. No effect (0) when the
// bodies are not approaching.
template <class S>
S strike(const Scene& scene, const Layout& layout, const ContactPair& pair, S* y);

}  // namespace atwood::dynamics
