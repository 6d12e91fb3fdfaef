// Derivatives of forward dynamics, by forward-mode differentiation (math/dual.hpp) of the articulated-body algorithm.
#pragma once

#include <vector>

#include "scene/scene.hpp"

namespace atwood {

// What a column is the derivative by.
enum class Along { displacement, rate, force };

// Of the accelerations u' of a tree under uniform gravity and the forces along its joints. Matrices have a row for each
// acceleration and a column for each rate k: the derivative by a displacement of the coordinates along the rate (of a
// ball or a free body's attitude: a small turn about an axis of the body), by the rate, and by a generalised force
// along it.
struct AccelerationDerivatives {
  int rates = 0;
  std::vector<double> acceleration, by_displacement, by_rate, by_force;
};

// `offsets`, `first_free`: the layout of the state, as for Tree; y: a state of `size` scalars, in which joints whose
// motion is prescribed are where the scene starts them; t_s: the time of the motors alone. The scene's other forces,
// closing joints and ropes are left out.
AccelerationDerivatives acceleration_derivatives(const Scene& scene, const std::vector<int>& offsets, int first_free,
                                                 const double* y, int size, double t_s = 0);

}  // namespace atwood
