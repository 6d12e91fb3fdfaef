// The start of a scene's mechanisms for both formulations.
#pragma once

#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::mechanism {

// mechanism_start() as a sample at t = 0: poses and velocities of bodies, coordinates and rates of joints, in quad.
// Throws MechanismError.
Sample start_sample(const Scene& scene);

}  // namespace atwood::mechanism
