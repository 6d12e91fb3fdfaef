#include "fluid/transport.hpp"

#include "fluid/slot_lanes.hpp"

namespace atwood::fluid {
namespace {

// each(j, x_ij, m_j V_j F_ij over the kernel's factor, record of j) for the neighbours of a block's lanes.
template <int d, class S, class Lanes, class Each>
ATWOOD_INLINE void over_neighbours(const TransportData<S>& data, const NeighbourBlock& block, const Lanes& lanes,
                                   const typename Lanes::Value (&own)[kRecordSize], const Each& each) {
  using V = typename Lanes::Value;
  const Kernel<S>& kernel = data.pairs.kernel;
  over_pairs<d>(
      data.lists, block, kernel, data.records, lanes, own,
      [](auto shape, const V& s) ATWOOD_INLINED { return kernel_slope<decltype(shape)::value, S>(s); },
      [&](std::ptrdiff_t j, const V(&x)[d], const V& F, const S* other)
          ATWOOD_INLINED { each(j, x, V(data.masses[j] * other[Record<d>::volume] * F), other); });
}

template <int d, class S, class Lanes>
ATWOOD_INLINE void block_velocities(const TransportData<S>& data, S strength, const NeighbourBlock& block, int first,
                                    const Lanes& lanes, S* transport) {
  using V = typename Lanes::Value;
  V own[kRecordSize], u[d]{};
  read_own_records(lanes, data.records + std::ptrdiff_t(first) * kRecordSize, own);
  over_neighbours<d>(data, block, lanes, own,
                     [&](std::ptrdiff_t, const V(&x)[d], const V& weight, const S*) ATWOOD_INLINED {
                       for (int c = 0; c < d; ++c) u[c] = u[c] + weight * x[c];
                     });
  const S factor = -strength * data.pairs.kernel.slope_factor;
  S* const out = transport + std::ptrdiff_t(first) * TransportRecord::size;
  for (int c = 0; c < d; ++c) lanes.write(V(factor * u[c]), out + TransportRecord::velocity + c, TransportRecord::size);
  lanes.write(lanes.own(data.densities + first, 1), out + TransportRecord::density, TransportRecord::size);
}

template <int d, class S, class Lanes>
ATWOOD_INLINE void block_fluxes(const TransportData<S>& data, const S* transport, const S* temperatures,
                                const NeighbourBlock& block, int first, const Lanes& lanes, S* sums,
                                S* temperature_rates) {
  using V = typename Lanes::Value;
  using R = Record<d>;
  const S* const own_transport = transport + std::ptrdiff_t(first) * TransportRecord::size;
  V own[kRecordSize], u[d], density{}, momentum[d]{}, heat_flux{}, T_i{};
  read_own_records(lanes, data.records + std::ptrdiff_t(first) * kRecordSize, own);
  for (int c = 0; c < d; ++c) u[c] = lanes.own(own_transport + TransportRecord::velocity + c, TransportRecord::size);
  const V rho_i = lanes.own(own_transport + TransportRecord::density, TransportRecord::size);
  if (temperatures != nullptr) T_i = lanes.own(temperatures + first, 1);
  const auto add = [&](std::ptrdiff_t j, const V(&x)[d], const V& weight, const S* other) ATWOOD_INLINED {
    const S* const transport_j = transport + j * TransportRecord::size;
    const S rho_j = transport_j[TransportRecord::density];
    V flux{}, divergence{};
    for (int c = 0; c < d; ++c) {
      const S u_j = transport_j[TransportRecord::velocity + c];
      flux = flux + x[c] * (rho_i * u[c] + rho_j * u_j);
      divergence = divergence + x[c] * (u_j - u[c]);
    }
    density = density + weight * (flux - rho_i * divergence);
    const V mass_flux = weight * flux;
    for (int c = 0; c < d; ++c) momentum[c] = momentum[c] + mass_flux * (other[R::velocity + c] - own[R::velocity + c]);
    if (temperatures != nullptr) heat_flux = heat_flux + mass_flux * (temperatures[j] - T_i);
  };
  over_neighbours<d>(data, block, lanes, own, add);
  const S factor = data.pairs.kernel.slope_factor;
  S* const out = sums + std::ptrdiff_t(first) * SumRecord::size;
  const auto add_to = [&](const V& change, int field) ATWOOD_INLINED {
    lanes.write(V(lanes.own(out + field, SumRecord::size) + change), out + field, SumRecord::size);
  };
  for (int c = 0; c < d; ++c) add_to(V(S(0.5) * factor * (momentum[c] / rho_i)), SumRecord::acceleration + c);
  add_to(V(factor * density), SumRecord::density);
  if (temperatures != nullptr) lanes.write(V(S(0.5) * factor * (heat_flux / rho_i)), temperature_rates + first, 1);
}

template <class S, class BlockOf>
void over_blocks(const TransportData<S>& data, int first, int last, const BlockOf& block_of) {
  in_lanes<S>(data.pairs.width, [&](auto width) ATWOOD_INLINED {
    for (int b = first; b < last; ++b) {
      const NeighbourBlock block = data.lists.block(b);
      over_lanes<S, decltype(width)::value>(
          data.pairs.lane_by_lane, [&](const auto& lanes) ATWOOD_INLINED { block_of(block, b * kLaneCount, lanes); });
    }
  });
}

}  // namespace

template <class S>
void set_transport_velocities(const TransportData<S>& data, S strength, int first, int last, S* transport) {
  over_blocks(data, first, last, [&](const NeighbourBlock& block, int slot, const auto& lanes) ATWOOD_INLINED {
    if (data.dimensions == 2) block_velocities<2>(data, strength, block, slot, lanes, transport);
    else block_velocities<3>(data, strength, block, slot, lanes, transport);
  });
}

template <class S>
void add_transport_fluxes(const TransportData<S>& data, const S* transport, const S* temperatures, int first, int last,
                          S* sums, S* temperature_rates) {
  over_blocks(data, first, last, [&](const NeighbourBlock& block, int slot, const auto& lanes) ATWOOD_INLINED {
    if (data.dimensions == 2)
      block_fluxes<2>(data, transport, temperatures, block, slot, lanes, sums, temperature_rates);
    else block_fluxes<3>(data, transport, temperatures, block, slot, lanes, sums, temperature_rates);
  });
}

#define ATWOOD_TRANSPORT(S)                                                            \
  template void set_transport_velocities<S>(const TransportData<S>&, S, int, int, S*); \
  template void add_transport_fluxes<S>(const TransportData<S>&, const S*, const S*, int, int, S*, S*);
ATWOOD_TRANSPORT(float)
ATWOOD_TRANSPORT(double)
ATWOOD_TRANSPORT(long double)
ATWOOD_TRANSPORT(Quad)
#undef ATWOOD_TRANSPORT

}  // namespace atwood::fluid
