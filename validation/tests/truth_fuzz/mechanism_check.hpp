// Mechanisms whose motion follows from one driven hinge or one rope, and four-bars, in 60 digits. The scenes are those
// of mechanism_kinds.cpp: their joints in the order that is given here, the axes z where nothing else is said.
#pragma once

#include "number.hpp"

namespace atwood::fuzz {

// joints: motor (crank), pin (crank and rod), rail (piston, along x), wrist (rod and piston). The end of the rod lies
// on a circle about the pin and on the rail: a quadratic equation for the piston's place.
Checked check_slider_crank(const Scenario& scenario, std::int64_t samples);
// joints: motor (first shaft), bearing (second shaft, its frame turned about x), cross (pins x of the first shaft and y
// of the second). The pins are orthogonal: one equation between the shafts' angles.
Checked check_hooke_shaft(const Scenario& scenario, std::int64_t samples);
// joints: motor (rod), bore (bead on the rod). Newton's law in the rod's frame, integrated by extrapolation.
Checked check_turning_rod(const Scenario& scenario, std::int64_t samples, int digits);
// joints: foot-0 .. foot-N (the bars), left-0 .. left-(N - 1) (bar k and coupling k), right-0 .. (coupling k and bar
// k + 1), all about z or -z. The bars' common angle is integrated by extrapolation; of the reactions the force across z
// is known, by elimination from Newton's and Euler's equations of all bodies, and the torque along z, which is 0.
Checked check_four_bar(const Scenario& scenario, std::int64_t samples, int digits);
// Ropes that hang straight down: the rope's acceleration balances the pull at its second end.
Checked check_atwood_machine(const Scenario& scenario, std::int64_t samples);

}  // namespace atwood::fuzz
