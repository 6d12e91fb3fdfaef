// Smooth motion in 60 digits: the equations of motion written anew, integrated by extrapolation of high order.
#pragma once

#include "number.hpp"

namespace atwood::fuzz {

// Forces of SCENE files but potentials and rotating frames; nothing may touch. `digits` (10 to 45): relative error asked
// of a step. `own` is the difference to a run that asks for four digits less.
Checked check_smooth(const Scenario& scenario, std::int64_t samples, int digits);

}  // namespace atwood::fuzz
