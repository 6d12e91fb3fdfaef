// What `shift` adds to the sums over pairs (docs/fluids.md): a transport velocity, and the fluxes relative to it. Of
// fluid particles without walls; in vector lanes as sums.hpp, with the same bits lane by lane.
#pragma once

#include "fluid/sums.hpp"

namespace atwood::fluid {

// Of a slot: the transport velocity [m/s], and the density.
struct TransportRecord {
  static constexpr int velocity = 0, density = 3, size = 4;
};

template <class S> struct TransportData {
  const PairSums<S>& pairs;
  const Neighbours<S>& lists;
  int dimensions;
  const S *records, *masses, *densities;  // by slot: Record<d>, one number, one number
};

// Of the blocks [first, last): u_i = - strength sum_j V_j F_ij x_ij, strength = shift U R. Sets the slots' records.
template <class S>
void set_transport_velocities(const TransportData<S>& data, S strength, int first, int last, S* transport);
// Their fluxes of mass, momentum and temperature are added to `sums` (SumRecord); temperatures: by slot, null where
// there are none; temperature_rates: by slot, set.
template <class S>
void add_transport_fluxes(const TransportData<S>& data, const S* transport, const S* temperatures, int first, int last,
                          S* sums, S* temperature_rates);

}  // namespace atwood::fluid
