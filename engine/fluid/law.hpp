// What a fluid is: equation of state, elastic energy, viscosity and heat, in the scalar of a run (docs/fluids.md).
#pragma once

#include "math/scalar.hpp"
#include "scene/fluid.hpp"

namespace atwood::fluid {

template <class S> struct FluidLaw {
  S density0{}, sound_speed{}, gamma{};
  bool tait = false;
  int whole_gamma = 0;  // gamma, where it is a small whole number; else 0
  S viscosity{};        // dynamic, rho0 nu [Pa s]
  S heat_capacity{}, conductivity{}, temperature0{}, expansion{}, viscosity_decay{};
  bool viscous_heat = false;

  S pressure(S density) const;
  S pressure_slope(S density) const;                           // dp / drho
  void pressures(const S* densities, S* of, int count) const;  // the same of many, to the last bit
  S density(S pressure) const;                                 // inverse of pressure(); NaN where there is none
  S elastic_energy(S density) const;                           // integral of p / rho^2 from rho0 [J/kg]
  S dynamic_viscosity(S temperature) const;                    // mu exp(-decay (T - T0))
};
template <class S> FluidLaw<S> make_law(const Fluid& fluid);

}  // namespace atwood::fluid
