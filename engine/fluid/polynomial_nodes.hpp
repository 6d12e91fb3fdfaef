// Values of the fluid's fields at a node of a wall or of the free surface, from the particles around it
// (docs/fluids.md, "Walls").
#pragma once

#include <vector>

#include "fluid/kernel.hpp"
#include "fluid/neighbours.hpp"

namespace atwood::fluid {

// Near walls the support grows by up to this share; that of nodes is as wide everywhere.
inline constexpr double kWidening = 0.4;

// A value at a node is the sum over these particles of weight times value.
template <class S> struct NodeWeights {
  std::vector<int> slots;
  std::vector<S> distance;       // along the normal [m]
  std::vector<S> unconstrained;  // no condition
  std::vector<S> given_slope;    // the slope along the normal is given: of values less slope times distance; or empty
};

template <class S> struct NodeFits {
  KernelShape shape = KernelShape::wendland_c2;
  int dimensions = 2;
  int degree = 2, slope_degree = 2;  // of the polynomials: unconstrained, and with a given slope
  int particles = 0;                 // points of the lists below this count; others are nodes and dummies
  S support{};                       // [m]

  // Of the node in a slot, whose normal is along an axis with a sign (axis < 0: unconstrained alone). False: too few
  // particles, or they do not determine the polynomials.
  bool around(const Neighbours<S>& lists, const S* records, int slot, int axis, S sign, NodeWeights<S>& weights) const;
};

}  // namespace atwood::fluid
