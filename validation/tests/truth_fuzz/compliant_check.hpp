// Compliant contact of two spheres, or of a sphere and a plane, along one line, in 60 digits.
#pragma once

#include "number.hpp"

namespace atwood::fuzz {

// The overlap d of a linear contact, m d'' = -k d - c d', by Taylor's series step by step; that of a Hertz contact,
// m d'' = -K d^(3/2), by its series in t^(5/2) and then by extrapolation up to the largest overlap, after which it is
// the time reversal. Bodies do not spin, or spin freely with equal moments of inertia.
Checked check_penalty(const Scenario& scenario, std::int64_t samples);

}  // namespace atwood::fuzz
