// What `corrected` and `shift` add to the sums over pairs (docs/fluids.md): loops over the lists of each slot, a particle
// at a time.
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

// Transport velocities [m/s]: d numbers a slot. strength = shift U R.
template <class S>
void set_transport_velocities(const CorrectionData<S>& data, S strength, int first, int last, S* transport);
// Their fluxes of mass, momentum and temperature. temperatures: by slot, null where there are none; temperature_rates:
// by slot, set.
template <class S>
void add_transport_fluxes(const CorrectionData<S>& data, const S* transport, const S* temperatures, int first, int last,
                          S* sums, S* temperature_rates);

}  // namespace atwood::fluid
