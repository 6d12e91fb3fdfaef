// Kick-drift steps of particles: leapfrog and its symmetric compositions, where the rate is x' = v, v' = a(x).
#pragma once

#include <memory>
#include <string>

#include "fluid/particle_system.hpp"
#include "integrators/stepper.hpp"
#include "protocol/fault.hpp"

namespace atwood::fluid {

// Spacings of an integer lattice for positions and velocities, powers of two; 0: none. Each drift and each kick is
// rounded to the lattice, the same in size whichever its sign, so that a symmetric method taken back with -h returns to
// the same bits (Levesque and Verlet, J. Stat. Phys. 72 (1993) 519). Doubles represent its points exactly up to 2^53
// spacings.
struct Lattice {
  double position_m = 0, velocity_m_per_s = 0;
};

// Is the scheme a kick-drift method ("leapfrog", "yoshida4")?
bool is_kick_drift(const std::string& scheme);

// The stepper of such a scheme. Fails where the system is not separable, or a lattice is asked for with a method that
// is not symmetric. The system outlives it.
template <class S>
Result<std::unique_ptr<Stepper<S>>> make_kick_drift(const std::string& scheme, ParticleSystem<S>& particles,
                                                    const Lattice& lattice, bool compensated);

// To the nearest point of a lattice, halves away from zero.
template <class S> S on_lattice(S value, S spacing);

}  // namespace atwood::fluid
