// Bounding spheres of shapes.
#pragma once

#include "scene/scene.hpp"

namespace atwood {

// The radius [m] of a sphere about the origin of the body's axes that holds the shape; for a compound it is not the
// smallest one. 0 for a body without a shape, infinite for a plane.
double bounding_radius_m(const Shape& shape);

}  // namespace atwood
