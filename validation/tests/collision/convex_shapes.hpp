// Shapes and rotations of the tests of convex pairs.
#pragma once

#include "posed_shapes.hpp"

namespace atwood::testing {

inline Geometry<double> shape(const Shape& s) { return make_geometry<double>(s); }
inline Quat<double> turn(double angle, const Vec3<double>& axis) {
  return {std::cos(angle / 2), std::sin(angle / 2) * axis.x, std::sin(angle / 2) * axis.y,
          std::sin(angle / 2) * axis.z};
}

}  // namespace atwood::testing
