// Bodies on a floor, and a ball that strikes a rod, in 60 digits.
#pragma once

#include "number.hpp"

namespace atwood::fuzz {

// One body (the second) slides, slips or rolls on a plane (the first): Coulomb's friction on the slip of the touching
// point as a vector, phase by phase. Slip, slope and spin lie along one line to the last bit.
Checked check_slide_or_roll(const Scenario& scenario, std::int64_t samples);

// A stack of boxes on a plane (the first body), each on the one before, edges parallel, gravity tilted: it rests if at
// each face the slope is within the cone of friction and the line of gravity from the centre of mass of all boxes above
// passes through the face. A stack that does not rest contradicts.
Checked check_rest(const Scenario& scenario, std::int64_t samples);

// A ball (the second body) strikes a capsule (the first) without gravity: the touch by bisection, the impact by Routh's
// method with the full matrix of the contact, then free rotation about a principal axis.
Checked check_struck_rod(const Scenario& scenario, std::int64_t samples);

}  // namespace atwood::fuzz
