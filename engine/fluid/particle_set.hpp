// The particles of a scene's fluids in the scalar of a run: laws, masses, layout of the state, its start and samples.
#pragma once

#include <string>
#include <vector>

#include "fluid/law.hpp"
#include "fluid/layout.hpp"
#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::fluid {

template <class S> struct ParticleSet {
  Layout layout;
  std::vector<FluidLaw<S>> laws;  // one a fluid
  std::vector<int> fluid_of;      // one a particle
  std::vector<S> mass;            // one a particle

  const FluidLaw<S>& law(int particle) const { return laws[fluid_of[particle]]; }
};

// density: whether densities are part of the state. Temperatures are, if some fluid has a heat capacity.
// body_scalars: length of the bodies' part of the state, which follows that of the particles.
template <class S> ParticleSet<S> make_particle_set(const Scene& scene, bool density, int body_scalars);

// Message if a period is too short for unique neighbours within `support` [m]; else empty. `what` names the support.
std::string period_fault(const Scene& scene, double support, const std::string& what);
// Message if float cannot hold the kernel's constants with all of its digits; else empty.
std::string float_fault(const Scene& scene, double support_m);

// The particles' part of the state at t = 0.
template <class S> void initial_particles(const ParticleSet<S>& set, const Scene& scene, S* y);

// sample.particles from a state; densities: one a particle (those of the state, or computed from it).
template <class S>
void write_particles(const ParticleSet<S>& set, const Scene& scene, const S* y, const S* densities, Sample& sample);

// "particle 17 of `water`": particles are counted over each fluid.
template <class S> std::string particle_name(const ParticleSet<S>& set, const Scene& scene, int particle);

// "[0.5, 0.25] m"
template <class S> std::string position_text(const S* x_m, int dimensions);

}  // namespace atwood::fluid
