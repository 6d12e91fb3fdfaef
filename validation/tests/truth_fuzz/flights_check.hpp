// Rigid balls that fly freely under uniform gravity between impacts, in 60 digits.
#pragma once

#include "number.hpp"

namespace atwood::fuzz {

// Balls (free or fixed) and planes; impacts by Newton's restitution and Coulomb's friction, one after another. `own` is
// the difference to a run whose instants of impact are moved by 1e-50 of their flights. Refuses: other shapes, forces,
// impacts at one instant, contacts that last (`most_impacts` in sum), overlaps at the start, friction on moments of
// inertia that are not all alike.
Checked check_flights(const Scenario& scenario, std::int64_t samples, int most_impacts = 400);

}  // namespace atwood::fuzz
