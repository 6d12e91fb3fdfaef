// Rigid balls that fly freely under uniform gravity between impacts, in 60 digits.
#pragma once

#include "number.hpp"

namespace atwood::fuzz {

// Balls (free or fixed) and planes; impacts by Newton's restitution and Coulomb's friction, one after another. `own` is
// the difference from a run whose impact times are shifted by 1e-50 of their flights. Refuses other shapes, forces,
// simultaneous impacts, lasting contacts (more than `most_impacts` impacts in total), overlaps at the start, and
// friction on bodies whose moments of inertia differ.
Checked check_flights(const Scenario& scenario, std::int64_t samples, int most_impacts = 400);

}  // namespace atwood::fuzz
