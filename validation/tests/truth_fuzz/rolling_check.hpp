// Bodies that roll: balls on a slab that is pushed over a floor, and a coin on its rim, in 60 digits.
#pragma once

#include "number.hpp"

namespace atwood::fuzz {

// A box (the second body) on a plane (the first) is pushed by the scene's only force and carries balls (the others),
// each on the line of the push through the box's centre. Every assignment of roll and slip to the balls is tried; one
// is consistent with Coulomb's law. Where the centre of pressure leaves the box, it contradicts.
Checked check_friction_cone(const Scenario& scenario, std::int64_t samples);

// A cylinder (the second body) that rolls without slip on its rim on the plane z = 0 (the first): Newton's and Euler's
// equations with the rolling constraint, integrated from the start's orientation and angular velocity by extrapolation
// with a relative error of 10^-digits a step. The start's velocity and height follow from the constraint.
Checked check_steady_roll(const Scenario& scenario, std::int64_t samples, int digits);

}  // namespace atwood::fuzz
