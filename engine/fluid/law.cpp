#include "fluid/law.hpp"

#include <quadmath.h>

#include <cmath>

#include "math/elementary.hpp"

namespace atwood::fluid {
namespace {

constexpr int kMaxWholeGamma = 16;

float power(float x, float y) { return static_cast<float>(real::power(x, y)); }
double power(double x, double y) { return real::power(x, y); }
long double power(long double x, long double y) { return std::pow(x, y); }
Quad power(Quad x, Quad y) { return powq(x, y); }
float exponential(float x) { return static_cast<float>(real::exp(x)); }
double exponential(double x) { return real::exp(x); }
long double exponential(long double x) { return std::exp(x); }
Quad exponential(Quad x) { return expq(x); }
float logarithm(float x) { return static_cast<float>(real::log(x)); }
double logarithm(double x) { return real::log(x); }
long double logarithm(long double x) { return std::log(x); }
Quad logarithm(Quad x) { return logq(x); }

template <class S> S whole_power(S x, int n) {
  S product = S(1);
  for (S square = x; n > 0; n >>= 1, square = square * square)
    if (n & 1) product = product * square;
  return product;
}

}  // namespace

template <class S> FluidLaw<S> make_law(const Fluid& fluid) {
  FluidLaw<S> law;
  law.density0 = S(fluid.density_kg_per_m3);
  law.sound_speed = S(fluid.sound_speed_m_per_s);
  law.gamma = S(fluid.tait_exponent);
  law.tait = fluid.equation_of_state == EquationOfState::tait;
  const int whole = fluid.tait_exponent <= kMaxWholeGamma ? static_cast<int>(fluid.tait_exponent) : 0;
  law.whole_gamma = whole == fluid.tait_exponent ? whole : 0;
  law.viscosity = S(fluid.density_kg_per_m3) * S(fluid.viscosity_m2_per_s);
  law.heat_capacity = S(fluid.heat_capacity_J_per_kg_K);
  law.conductivity = S(fluid.conductivity_W_per_m_K);
  law.temperature0 = S(fluid.temperature_K);
  law.expansion = S(fluid.expansion_per_K);
  law.viscosity_decay = S(fluid.viscosity_decay_per_K);
  law.viscous_heat = fluid.viscous_heat;
  return law;
}

template <class S> S FluidLaw<S>::pressure(S density) const {
  const S c2 = sound_speed * sound_speed;
  if (!tait) return c2 * (density - density0);
  const S ratio = density / density0;
  const S raised = whole_gamma > 0 ? whole_power(ratio, whole_gamma) : power(ratio, gamma);
  return density0 * c2 / gamma * (raised - S(1));
}

// Of Tait's law c^2 (rho / rho0)^(gamma - 1) = (c^2 + gamma p / rho0) rho0 / rho.
template <class S> S FluidLaw<S>::pressure_slope(S density) const {
  const S c2 = sound_speed * sound_speed;
  return tait ? (c2 * density0 + gamma * pressure(density)) / density : c2;
}

template <class S> void FluidLaw<S>::pressures(const S* densities, S* of, int count) const {
  if (!tait) {
    const S c2 = sound_speed * sound_speed;
    for (int k = 0; k < count; ++k) of[k] = c2 * (densities[k] - density0);
  } else {
    for (int k = 0; k < count; ++k) of[k] = pressure(densities[k]);
  }
}

template <class S> S FluidLaw<S>::density(S pressure) const {
  const S c2 = sound_speed * sound_speed;
  if (!tait) return density0 + pressure / c2;
  return density0 * power(S(1) + gamma * pressure / (density0 * c2), S(1) / gamma);
}

template <class S> S FluidLaw<S>::elastic_energy(S density) const {
  const S c2 = sound_speed * sound_speed, ratio = density / density0;
  if (!tait || gamma == S(1)) return c2 * (logarithm(ratio) + S(1) / ratio - S(1));
  const S gamma_minus_one = gamma - S(1);
  const S raised = whole_gamma > 0 ? whole_power(ratio, whole_gamma - 1) : power(ratio, gamma_minus_one);
  return c2 / gamma * (raised / gamma_minus_one + S(1) / ratio - gamma / gamma_minus_one);
}

template <class S> S FluidLaw<S>::dynamic_viscosity(S temperature) const {
  if (viscosity_decay == S(0)) return viscosity;
  return viscosity * exponential(-viscosity_decay * (temperature - temperature0));
}

#define ATWOOD_LAW(S)          \
  template struct FluidLaw<S>; \
  template FluidLaw<S> make_law<S>(const Fluid&);
ATWOOD_LAW(float)
ATWOOD_LAW(double)
ATWOOD_LAW(long double)
ATWOOD_LAW(Quad)
#undef ATWOOD_LAW

}  // namespace atwood::fluid
