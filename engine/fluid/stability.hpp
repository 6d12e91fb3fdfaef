// Linear stability of a method on a lattice of particles. The method steps the equations of plane waves on the lattice;
// none may grow.
//
// With the symbols of the sums on a lattice of spacing D, of the wave vector k along an axis or a diagonal,
//   G(k) = |sum_j V F_ij x_ij sin(k . x_ij)|
//   L(k) = -2 sum_j V F_ij (1 - cos(k . x_ij))
// the waves are
//   longitudinal  a' = -c G q - nu_l L a,  q' = c G a - delta h c L q
//   transverse    a' = -nu L a
//   thermal       T' = -k / (rho0 C) L T
// An explicit method is stable for sound waves within its interval of the imaginary axis; that of explicit Euler's and
// Heun's methods is empty.
#pragma once

#include <complex>
#include <cstdint>
#include <string>
#include <vector>

#include "fluid/kernel.hpp"
#include "protocol/setting.hpp"
#include "scene/scene.hpp"

namespace atwood::fluid {

struct ModeRates {
  double sound_speed_m_per_s = 0;
  double longitudinal_m2_per_s = 0, transverse_m2_per_s = 0;  // kinematic viscosity of the two
  double thermal_m2_per_s = 0, density_m2_per_s = 0;          // diffusivities
  double gravity_m_per_s2 = 0;
};

struct EqualSteps {
  double h_s = 0;
  std::int64_t steps = 1;
  std::int64_t samples = 1;  // of which the number of steps is a multiple
  double t_end_s() const { return h_s * static_cast<double>(steps); }
};

// Why `scheme` may not take these steps, with the bounds and a number of steps that it may take; empty: it may. Waves
// may grow by a tenth over the run. The bounds are those of runs as long as this one.
std::string instability_message(const std::string& scheme, const Settings& overrides, const Kernel<double>& kernel,
                                double spacing_m, const ModeRates& rates, const EqualSteps& asked);

// The same for modes y' = lambda y with extremal eigenvalues [1/s] (spectrum.hpp), and for undamped
// oscillations of all frequencies up to the highest one: sound waves of all lengths. A mode that grows by its own
// equation may grow as fast.
std::string instability_message(const std::string& scheme, const Settings& overrides,
                                const std::vector<std::complex<double>>& eigenvalues, const EqualSteps& asked);

}  // namespace atwood::fluid
