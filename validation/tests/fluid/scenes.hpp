// Small scenes of fluids for tests: particles are placed here, by hand.
#pragma once

#include <cmath>

#include "scene/scene.hpp"
#include "scene/split_mix.hpp"

namespace atwood {

struct BlockOptions {
  int dimensions = 2, across = 8;  // particles along an edge
  double spacing_m = 0.125, disturbance = 0.2, speed_m_per_s = 1;
  bool periodic = true;
  std::uint64_t seed = 1;
};

// A square or a cube of one fluid with its corner at the origin: disturbed, with smooth velocities and densities.
inline Scene block_scene(const BlockOptions& options = {}) {
  Scene scene;
  const int d = options.dimensions, n = options.across;
  const double size = n * options.spacing_m, pi = std::acos(-1.0);
  scene.domain.dimensions = d;
  if (options.periodic)
    for (int c = 0; c < d; ++c) scene.domain.periodic_m[c] = size;
  Fluid fluid;
  fluid.name = "water";
  fluid.spacing_m = options.spacing_m;
  fluid.density_kg_per_m3 = 1000;
  fluid.sound_speed_m_per_s = 10;
  fluid.viscosity_m2_per_s = 0.01;
  SplitMix64 random{options.seed};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < (d == 3 ? n : 1); ++k) {
        const int at[3] = {i, j, k};
        Real3 x{}, v{};
        for (int c = 0; c < d; ++c) x[c] = (at[c] + 0.5 + options.disturbance * random.next_unit()) * options.spacing_m;
        v[0] = options.speed_m_per_s * (std::sin(2 * pi * x[1] / size) + 0.3);
        v[1] = -options.speed_m_per_s * std::cos(2 * pi * x[0] / size);
        if (d == 3) v[2] = 0.5 * options.speed_m_per_s * std::sin(2 * pi * (x[0] + x[1]) / size);
        fluid.particles.position_m.push_back(x);
        fluid.particles.velocity_m_per_s.push_back(v);
        fluid.particles.density_kg_per_m3.push_back(1000 * (1 + 0.005 * std::sin(2 * pi * x[0] / size)));
        fluid.particles.mass_kg.push_back(1000 * std::pow(options.spacing_m, d));
        fluid.particles.temperature_K.push_back(300 + 5 * std::sin(2 * pi * (x[0] - x[1]) / size));
      }
  fluid.temperature_K = 300;
  scene.fluids.push_back(fluid);
  return scene;
}

inline void heat(Fluid& fluid) {
  fluid.heat_capacity_J_per_kg_K = 400;
  fluid.conductivity_W_per_m_K = 2000;
  fluid.viscous_heat = true;
  fluid.expansion_per_K = 1e-3;
  fluid.viscosity_decay_per_K = 0.01;
}

}  // namespace atwood
