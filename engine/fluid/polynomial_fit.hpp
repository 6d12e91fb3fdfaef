// Fits of polynomials to the neighbourhoods of particles by moving least squares (docs/fluids.md, "The fit"):
// derivatives of velocity, density and temperature, the filter's change, and the sum that shifting takes.
//
// One loop, written for a lane or for a pack of lanes (math/pack.hpp): lane by lane it is the readable reference, and
// the pack gives each lane the same bits.
//
// Sources: Lancaster and Salkauskas, Math. Comp. 37 (1981) 141; Liszka and Orkisz, Computers & Structures 11 (1980) 83.
#pragma once

#include <vector>

#include "fluid/kernel.hpp"
#include "fluid/neighbours.hpp"
#include "math/vector_width.hpp"

namespace atwood::fluid {

// The numbers of a slot: position (d), then the fields: velocity (d), density, temperature; padded to 8.
inline constexpr int kFitRecord = 8;
inline constexpr int kMaxFields = 5;

// Weights of a slot.
template <class S> struct SlotWeight {
  S fit;        // in the fits of its neighbours
  S shift_sum;  // in their sums for shifting
  S surface;    // 1: a node of the free surface; 0: none
};

// What the fits of a slot give. Field f is component f of velocity, density (f = d), temperature (f = d + 1).
template <class S> struct Fit {
  S gradient[kMaxFields][3];
  S laplacian[kMaxFields];
  S change[kMaxFields];  // G f of docs/fluids.md
  S shift_sum[3];        // sum of (1 - r / (2 D))^3 (x_j - x_i) [m]
  S depth_factor;        // product of 1 - (1 - (r / (2 D))^2)^3 over the nodes of the free surface within 2 D
  S least_pivot;         // of the Cholesky factors of M, scaled to a unit diagonal; <= 0 or NaN: singular
};

template <class S> struct PolynomialFits {
  KernelShape shape = KernelShape::wendland_c2;
  int dimensions = 2, degree = 2, fields = 3;  // fields = d + 1, or d + 2 with temperature
  S spacing{};                                 // D
  VectorWidth width = widest_vectors();
  bool lane_by_lane = false;  // the reference

  // The fits of the slots of the blocks [first, last). supports: R of each slot [m]; weights: of each slot, null: all
  // 1. scratch is resized where it is too small.
  void fit(const Neighbours<S>& lists, const S* records, const S* supports, const SlotWeight<S>* weights,
           int first_block, int last_block, LaneArray<S>& scratch, Fit<S>* out) const;
};

}  // namespace atwood::fluid
