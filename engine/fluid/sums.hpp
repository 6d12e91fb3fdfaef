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

// Where the numbers of a slot stand in its record: position, velocity, then these.
template <int d> struct Record {
  static constexpr int position = 0, velocity = d;
  static constexpr int pressure_term = 2 * d;  // p / rho^2
  static constexpr int mass = 2 * d + 1;       // 0: points of walls
  static constexpr int volume = 2 * d + 2;     // 1 / rho, of a unit of mass
  static constexpr int viscosity = 2 * d + 3;  // mu
  static constexpr int size = d == 2 ? 8 : 10;
};
// What only some fluids need, in a record of its own.
struct HeatRecord {
  static constexpr int temperature = 0, conductivity = 1, fluid = 2, sound_speed = 3, size = 4;
};
// The sums of a slot: acceleration by pressure and viscosity, rate of density, and heat [W/kg] by conduction and
// viscosity. Without the particle's own gravity, source and heat capacity.
struct SumRecord {
  static constexpr int acceleration = 0, density = 3, heat = 4, size = 5;
};

template <class S> struct PairSums {
  Kernel<S> kernel;
  Viscosity viscosity = Viscosity::none;
  bool continuity = true, conduction = false, viscous_heat = false, several_fluids = false;
  S diffusion{};  // 2 delta h, times c of the only fluid
  VectorWidth width = widest_vectors();
  bool lane_by_lane = false;  // the reference

  // Of the blocks [first, last): `records` hold Record<d>::size numbers a slot, `heat` HeatRecord::size (null where
  // neither conduction nor several fluids), `sums` SumRecord::size.
  void add_forces(const Neighbours<S>& lists, int dimensions, const S* records, const S* heat, int first, int last,
                  S* sums) const;
  // rho_i = m_i W(0) + sum_j m_j W_ij; `masses` of all slots, walls included.
  void add_densities(const Neighbours<S>& lists, int dimensions, const S* records, const S* masses, int first, int last,
                     S* densities) const;
};

}  // namespace atwood::fluid
