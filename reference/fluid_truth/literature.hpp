// Published measurements and computations, with the band that their reading has.
#pragma once

#include "protocol/fluid_field.hpp"
#include "scene/scene.hpp"

namespace atwood {

// truth.solution = "martin-moyce": the front of a collapsing column on a dry bed as the probe of kind `front`; a time
// outside the table has no value. Status::unsupported with a reason for anything else.
FluidField literature_field(const Scenario& scenario);

}  // namespace atwood
