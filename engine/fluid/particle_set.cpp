#include "fluid/particle_set.hpp"

#include <algorithm>
#include <cmath>

namespace atwood::fluid {

std::string period_fault(const Scene& scene, double support, const std::string& what) {
  for (int axis = 0; axis < scene.domain.dimensions; ++axis) {
    const double period = scene.domain.periodic_m[axis];
    if (period > 0 && period < 2 * support)
      return what + ", " + format_double(support) + " m, is more than half the period of " + format_double(period) +
             " m along " + "xyz"[axis] +
             ": a particle would have another as a neighbour twice; take a smaller spacing or smoothing";
  }
  return "";
}

std::string float_fault(const Scene& scene, double support) {
  constexpr double largest = 1e31;  // FLT_MAX times the rounding unit, and the inverse of FLT_MIN over it
  const int power = scene.domain.dimensions + 2;
  const double factor = std::pow(support, -power);
  if (factor <= largest && factor >= 1 / largest) return "";
  return "the kernel's support of " + format_double(support) + " m leaves the range of @float: 1 / support^" +
         std::to_string(power) + ", in the gradient of the kernel, is " + format_double(factor) +
         "; take another scalar, or a unit of length that is nearer to the spacing (expected 1e-31 to 1e+31)";
}

template <class S> ParticleSet<S> make_particle_set(const Scene& scene, bool density, int body_scalars) {
  ParticleSet<S> set;
  for (std::size_t f = 0; f < scene.fluids.size(); ++f) {
    const Fluid& fluid = scene.fluids[f];
    set.laws.push_back(make_law<S>(fluid));
    set.layout.temperature = set.layout.temperature || fluid.heat_capacity_J_per_kg_K > 0;
    for (const double mass : fluid.particles.mass_kg) {
      set.mass.push_back(S(mass));
      set.fluid_of.push_back(static_cast<int>(f));
    }
  }
  set.layout.dimensions = scene.domain.dimensions;
  set.layout.particles = static_cast<int>(set.mass.size());
  set.layout.density = density;
  set.layout.body_scalars = body_scalars;
  return set;
}

template <class S> void initial_particles(const ParticleSet<S>& set, const Scene& scene, S* y) {
  const Layout& at = set.layout;
  int i = 0;
  for (const Fluid& fluid : scene.fluids) {
    const Particles& particles = fluid.particles;
    for (std::size_t k = 0; k < particles.mass_kg.size(); ++k, ++i) {
      for (int c = 0; c < at.dimensions; ++c) {
        y[at.positions() + i * at.dimensions + c] = S(particles.position_m[k][c]);
        y[at.velocities() + i * at.dimensions + c] = S(particles.velocity_m_per_s[k][c]);
      }
      if (at.density) y[at.densities() + i] = S(particles.density_kg_per_m3[k]);
      if (at.temperature) y[at.temperatures() + i] = S(particles.temperature_K[k]);
    }
  }
}

template <class S>
void write_particles(const ParticleSet<S>& set, const Scene& scene, const S* y, const S* densities, Sample& sample) {
  const Layout& at = set.layout;
  sample.particles.resize(at.particles);
  for (int i = 0; i < at.particles; ++i) {
    ParticleSample& out = sample.particles[i];
    for (int c = 0; c < at.dimensions; ++c) {
      out.p_m[c] = y[at.positions() + i * at.dimensions + c];
      out.v_m_per_s[c] = y[at.velocities() + i * at.dimensions + c];
    }
    out.density_kg_per_m3 = densities[i];
    out.pressure_Pa = set.law(i).pressure(densities[i]);
    out.temperature_K =
        at.temperature ? Wide(y[at.temperatures() + i]) : Wide(scene.fluids[set.fluid_of[i]].temperature_K);
  }
}

template <class S> std::string particle_name(const ParticleSet<S>& set, const Scene& scene, int particle) {
  const auto first = std::lower_bound(set.fluid_of.begin(), set.fluid_of.end(), set.fluid_of[particle]);
  return "particle " + std::to_string(particle - (first - set.fluid_of.begin())) + " of `" +
         scene.fluids[set.fluid_of[particle]].name + "`";
}

template <class S> std::string position_text(const S* x_m, int dimensions) {
  std::string text = "[";
  for (int c = 0; c < dimensions; ++c) text += (c > 0 ? ", " : "") + format_double(static_cast<double>(x_m[c]));
  return text + "] m";
}

#define ATWOOD_PARTICLE_SET(S)                                                                        \
  template struct ParticleSet<S>;                                                                     \
  template ParticleSet<S> make_particle_set<S>(const Scene&, bool, int);                              \
  template void initial_particles<S>(const ParticleSet<S>&, const Scene&, S*);                        \
  template void write_particles<S>(const ParticleSet<S>&, const Scene&, const S*, const S*, Sample&); \
  template std::string particle_name<S>(const ParticleSet<S>&, const Scene&, int);                    \
  template std::string position_text<S>(const S*, int);
ATWOOD_PARTICLE_SET(float)
ATWOOD_PARTICLE_SET(double)
ATWOOD_PARTICLE_SET(long double)
ATWOOD_PARTICLE_SET(Quad)
#undef ATWOOD_PARTICLE_SET

}  // namespace atwood::fluid
