// Mutual gravity of many bodies: positions gathered once into structure of arrays, then direct sums or a tree.
#pragma once

#include "forces/force.hpp"

namespace atwood {

// From here on the vector lanes are quicker than the loop over pairs, whose bits direct sums keep.
inline constexpr int kManyBodies = 16;

// Null where mutual_gravity.cpp's loop over pairs serves: few bodies, or a scalar without vector lanes. Throws
// Unsupported for a tree in such a scalar.
template <class S>
TermPointer<S> make_many_body_gravity(const MutualGravity& force, const Scene& scene, const GravityOptions& options);

}  // namespace atwood
