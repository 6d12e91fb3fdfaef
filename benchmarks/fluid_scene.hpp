// A periodic block of fluid for measurements of speed, of any number of particles.
#pragma once

#include "scene/fluid_points.hpp"
#include "scene/scene.hpp"

// The unit square or cube, `across` disturbed particles along each axis; viscous, sound speed 10 m/s. Vortices move in
// planes of constant z.
inline atwood::Scene fluid_block(int dimensions, int across) {
  atwood::Scene scene;
  scene.materials.push_back({"default", 0, 0, 0});
  scene.pairs.push_back({0, 0, 0, 0, 0});
  scene.domain.dimensions = dimensions;
  atwood::Fluid fluid;
  atwood::BoxRegion box;
  for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions); ++i)
    scene.domain.periodic_m[i] = 1, box.max_m[i] = 1;
  fluid.name = "water";
  fluid.region = box;
  fluid.arrangement = atwood::Arrangement::disturbed;
  fluid.disturbance = 0.2;
  fluid.spacing_m = 1.0 / across;
  fluid.density_kg_per_m3 = 1000;
  fluid.sound_speed_m_per_s = 10;
  fluid.viscosity_m2_per_s = 1e-3;
  fluid.initial = {"taylor-green", {{"speed_m_per_s", 1}, {"length_m", 1}, {"mode", 1}}};
  scene.fluids.push_back(fluid);
  atwood::place_particles(scene);
  return scene;
}

// A step at a quarter of the time that sound takes from particle to particle [s].
inline double fluid_block_step_s(int across) { return 0.25 / (10.0 * across); }
