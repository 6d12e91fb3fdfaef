// The particles of a scene as one flat system of equations, in the layout of docs/fluids.md: all positions (unwrapped),
// all velocities, all densities where they are integrated, all temperatures where a fluid has a heat capacity, the
// nodes of a free surface; d or 1 numbers a particle, particle after particle.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fluid_truth/kernel.hpp"
#include "fluid_truth/response.hpp"
#include "fluid_truth/walls.hpp"
#include "scene/scene.hpp"

namespace atwood::fluid_truth {

struct ParticleLayout {
  int d = 2, count = 0;
  int velocity = 0, density = -1, temperature = -1, size = 0;  // first index of each; -1: not integrated
  int nodes = 0, node_count = 0;                               // of a free surface: positions
};

// A fluid's constants over S.
template <class S> struct FluidLaw {
  bool tait = false, viscous_heat = false;
  S rho0{}, c{}, gamma{}, nu{}, decay{}, heat_capacity{}, conductivity{}, T0{}, expansion{};

  S pressure(S density) const;
  S pressure_slope(S density) const;  // dp / d rho
  S density_at(S pressure) const;
  S dynamic_viscosity(S T) const;  // rho0 nu exp(-decay (T - T0))
};

// What both families of equations read from the scene.
template <class S> struct ParticleData {
  ParticleLayout layout;
  std::vector<FluidLaw<S>> laws;
  std::vector<int> fluid;  // of each particle
  std::vector<S> mass;
  std::vector<double> fixed_temperature;
  Vec<S> gravity{}, period{};
  double spacing = 0;
  double largest_speed = 0, largest_sound_speed = 0;
  std::vector<std::function<Vec<S>(S t, const Vec<S>& x)>> source;  // one a fluid; empty: none
  std::vector<FixedPoint<S>> points;                                // of walls, for `+sph`

  Vec<S> read(const S* from, int i) const {  // d numbers of particle i
    const S* at = from + static_cast<std::size_t>(i) * layout.d;
    return {at[0], at[1], layout.d == 3 ? at[2] : S(0)};
  }
};
// Throws Refused where the scene has no particles or something that the semi-discrete truth does not cover.
template <class S> ParticleData<S> particle_data(const Scene& scene, bool density_integrated);
template <class S> std::vector<S> initial_state(const Scene& scene, const ParticleLayout& layout);

// Pairs of points nearer than R, found anew at each call: from every pair where there are few points, else by cells at
// least R wide. `other`: in ascending order; the difference x = x_i - x_other is that of the nearest image.
template <class S> struct Neighbour {
  int other = 0;
  Vec<S> x{};
  S r{};
};
template <class S>
std::vector<std::vector<Neighbour<S>>> neighbours_of(const ParticleData<S>& data, const std::vector<Vec<S>>& x, S R);

// A semi-discrete system: rates, and the densities and pressures that go with a state.
template <class S> class FluidSystem {
 public:
  virtual ~FluidSystem() = default;
  virtual void rate(S t, const S* y, S* dydt) = 0;
  virtual std::vector<S> densities(const S* y) = 0;
  ParticleData<S> data;
};

// `+sph` and `+polynomial`: docs/fluids.md. Throw Refused for settings or scenes that are not covered.
template <class S> std::unique_ptr<FluidSystem<S>> sph_system(const Scene& scene, const Response& response);
template <class S> std::unique_ptr<FluidSystem<S>> polynomial_system(const Scene& scene, const Response& response);
template <class S> std::unique_ptr<FluidSystem<S>> fluid_system(const Scene& scene, const std::string& response);

}  // namespace atwood::fluid_truth
