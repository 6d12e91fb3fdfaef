// What `corrected` adds to the sums over pairs (docs/fluids.md): loops over the lists of each slot, a particle at a
// time.
#pragma once

#include "fluid/sums.hpp"

namespace atwood::fluid {

// Of the slots [first, last), fluid particles without walls. pressures, densities, masses: by slot.
template <class S> struct CorrectionData {
  const Neighbours<S>& lists;
  const Kernel<S>& kernel;
  int dimensions;
  const S* records;  // positions and velocities
  const S *masses, *densities, *pressures;
};

// First-order exact gradients of pressure and divergences of velocity: acceleration and rate of density are added.
template <class S> void add_corrected_gradients(const CorrectionData<S>& data, int first, int last, S* sums);

}  // namespace atwood::fluid
