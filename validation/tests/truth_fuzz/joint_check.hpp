// Bodies on joints to the world or to fixed bodies, each with a motion of its own, in 60 digits.
#pragma once

#include "number.hpp"

namespace atwood::fuzz {

// Hinges and sliders under gravity, springs, dampers and motors, and between stops; ball joints under gravity. Euler's
// and Newton's equations for each body, integrated by extrapolation with a relative error of 10^-digits per step;
// between stops, under a constant force, flight by flight.
Checked check_joints(const Scenario& scenario, std::int64_t samples, int digits);

}  // namespace atwood::fuzz
