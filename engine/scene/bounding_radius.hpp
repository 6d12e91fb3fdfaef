// How far a shape reaches from its body's origin.
#pragma once

#include "scene/scene.hpp"

namespace atwood {

// The radius [m] of a sphere about the origin of the body's axes that holds the shape; of a compound not the smallest.
// 0 for a body without a shape, infinite for a plane.
double bounding_radius_m(const Shape& shape);

}  // namespace atwood
