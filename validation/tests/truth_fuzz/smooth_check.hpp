// Smooth motion in 60 digits: independently written equations of motion, integrated by extrapolation of high order.
#pragma once

#include "number.hpp"

namespace atwood::fuzz {

// Takes all forces of scene files except potentials and rotating frames; bodies must not touch. `digits` (10 to 45):
// the relative error per step is 10^-digits. `own` is the difference from a run with four digits less.
Checked check_smooth(const Scenario& scenario, std::int64_t samples, int digits);

}  // namespace atwood::fuzz
