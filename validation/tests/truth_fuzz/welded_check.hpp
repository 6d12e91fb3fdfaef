// Bodies that fixed joints weld together, in 60 digits.
#pragma once

#include "number.hpp"

namespace atwood::fuzz {

// Fixed joints weld the bodies to each other, the parent before the child: each assembly is one rigid body by Steiner's
// theorem, whose free turn is integrated by extrapolation.
Checked check_welded_bodies(const Scenario& scenario, std::int64_t samples, int digits);

}  // namespace atwood::fuzz
