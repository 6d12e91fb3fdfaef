// The field of the weakly compressible equations, one for each equation of state and viscous term.
#pragma once

#include "protocol/fluid_field.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Two dimensions, both periodic; the initial fields taylor-green (its density is that of the incompressible pressure,
// so that no sound is started at the order of M^2), shear, standing-wave and mms-2d. The bar is twice the largest
// difference, over the positions of a call, between the solution and one of fewer points and one of a tolerance a
// thousand times larger. Points are added until it is small (or it says what it is). Otherwise Status::unsupported;
// never throws.
FluidField weakly_compressible_field(const Scenario& scenario, const std::string& response);

}  // namespace atwood
