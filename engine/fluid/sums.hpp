// The sums over pairs of `+sph` (docs/fluids.md), for fluid particles alone; those with walls stand in walls.hpp.
//
// One loop, written for a lane or for a pack of lanes (math/pack.hpp): lane by lane it is the readable reference, and
// the pack gives each lane the same bits.
#pragma once

#include <vector>

#include "fluid/kernel.hpp"
#include "fluid/neighbours.hpp"
#include "math/vector_width.hpp"

namespace atwood::fluid {

enum class Viscosity { none, morris, central };

// Where the numbers of a slot stand in its record: position, velocity, p / rho^2, 1 / rho. One line of the cache.
template <int d> struct Record {
  static constexpr int position = 0, velocity = d, pressure_term = 2 * d, volume = 2 * d + 1;
};
inline constexpr int kRecordSize = 8;
// What only some fluids need, in a record of its own.
struct HeatRecord {
  static constexpr int temperature = 0, conductivity = 1, fluid = 2, sound_speed = 3, size = 4;
};
// The sums of a slot: acceleration by pressure and viscosity, rate of density, and heat [W/kg] by conduction and
// viscosity. Without the particle's own gravity, source and heat capacity.
struct SumRecord {
  static constexpr int acceleration = 0, density = 3, heat = 4, size = 5;
};

// What the sums read, all by slot.
template <class S> struct SlotData {
  const S* records = nullptr;      // kRecordSize numbers a slot, aligned to them
  const S* masses = nullptr;       // 0: points of walls; null: `mass` everywhere
  const S* viscosities = nullptr;  // mu; null: `viscosity` everywhere
  const S* heat = nullptr;         // HeatRecord::size numbers a slot; null: neither conduction nor several fluids
  S mass{}, viscosity{};
};

template <class S> struct PairSums {
  Kernel<S> kernel;
  Viscosity viscosity = Viscosity::none;
  bool gradients = true;  // of pressure and divergence of velocity; false: corrected ones take their place
  bool conduction = false, viscous_heat = false, several_fluids = false;
  S diffusion{};  // 2 delta h, times c of the only fluid
  VectorWidth width = widest_vectors();
  bool lane_by_lane = false;  // the reference

  // Of the blocks [first, last): SumRecord::size numbers a slot.
  void add_forces(const Neighbours<S>& lists, int dimensions, const SlotData<S>& data, int first, int last,
                  S* sums) const;
  // rho_i = m_i W(0) + sum_j m_j W_ij; `masses` of all slots, walls included.
  void add_densities(const Neighbours<S>& lists, int dimensions, const S* records, const S* masses, int first, int last,
                     S* densities) const;
};

}  // namespace atwood::fluid
