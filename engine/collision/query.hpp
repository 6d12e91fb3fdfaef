// Contact queries on a scene: all pairs, in double.
#pragma once

#include "protocol/contact_query.hpp"
#include "protocol/pair_query.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Contacts of the initial pose (touching exactly counts, with depth 0), or the first touch of every pair until
// query.t_end_s. Pairs of two fixed bodies and bodies without a shape are left out. Ordered by pair, then as the narrow
// phase orders them. Unsupported where a pair has no test, with the reason.
ContactAnswer find_scene_contacts(const Scene& scene, const ContactQuery& query);

// Closest or deepest points of two bodies (indices into scene.bodies) in the initial pose. Throws
// std::invalid_argument, naming the pair of kinds, if there is no test for it.
PairGap find_pair_gap(const Scene& scene, int a, int b);

}  // namespace atwood
