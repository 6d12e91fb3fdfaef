// Mutual gravity of many bodies: positions gathered once into structure of arrays, then direct sums or a tree.
#pragma once

#include "forces/force.hpp"

namespace atwood {

// From this number of bodies on the vector lanes are faster than the loop over pairs; the results are the same bits.
inline constexpr int kManyBodies = 16;

// Null for few bodies and for scalars without vector lanes: the loop over pairs of mutual_gravity.cpp is then used.
// Throws Unsupported for a tree in such a scalar.
template <class S>
TermPointer<S> make_many_body_gravity(const MutualGravity& force, const Scene& scene, const GravityOptions& options);

}  // namespace atwood
