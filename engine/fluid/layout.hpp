// Where the unknowns of the fluids stand in the flat state of a run, one block after another, particle-major:
//
//   positions     d numbers a particle, unwrapped in periodic directions
//   velocities    d numbers a particle
//   densities     1 number a particle, where density is integrated
//   temperatures  1 number a particle, where the fluids have a heat capacity
//   bodies        as in rigid/model.hpp
//   nodes         d numbers a node of the free surface (+polynomial), positions
//
// Particles are those of all fluids, in the order of Scene::fluids.
#pragma once

namespace atwood::fluid {

struct Layout {
  int dimensions = 3, particles = 0;
  bool density = false, temperature = false;
  int body_scalars = 0;
  int surface_nodes = 0;

  constexpr int positions() const { return 0; }
  constexpr int velocities() const { return dimensions * particles; }
  constexpr int densities() const { return 2 * dimensions * particles; }
  constexpr int temperatures() const { return densities() + (density ? particles : 0); }
  constexpr int bodies() const { return temperatures() + (temperature ? particles : 0); }
  constexpr int nodes() const { return bodies() + body_scalars; }
  constexpr int size() const { return nodes() + dimensions * surface_nodes; }
};

}  // namespace atwood::fluid
