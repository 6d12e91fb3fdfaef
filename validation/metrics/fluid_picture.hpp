// What a report draws of a fluid: its particles at the last sample, thinned to a bounded number.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "validation/metrics/fluid.hpp"

namespace atwood {

inline constexpr std::size_t kMaxDrawn = 2500;

// One entry a particle in every list; `temperature_K` and `error` may be empty. Positions are wrapped into the periodic
// cell. In three dimensions: the particles within half a spacing of the middle plane across z.
struct FluidPicture {
  double t_s = 0, side_m = 0;  // side: of the square that a particle stands for
  std::int64_t particles = 0;  // of the run, of which these are some
  std::array<double, 2> low_m{}, high_m{};
  std::string error_of;  // "velocity [m/s]"; empty: no exact field is known
  std::vector<float> x_m, y_m, speed_m_per_s, pressure_Pa, temperature_K, error;
  bool empty() const { return x_m.empty(); }
};

// Of at most kMaxDrawn particles all; of more, one of each square of the coarsest grid that keeps at most so many: the
// first in the order of the scene. `error`: |v - u|, or where the exact fluid rests everywhere that of its temperature,
// else of its pressure. Empty for a run that did not end well.
FluidPicture picture_of(const Scenario& scenario, const FieldAtParticles& exact, const Recording& run);

}  // namespace atwood
