// Contacts and distances by FCL: fcl::collide with its own solver settings (contacts on, at
// most 64), fcl::distance with nearest points. A plane is a half space, a rectangle a box of zero thickness, a mesh a
// surface in a tree of oriented boxes.
//
// Properties of FCL: no distance to a half space; negative depths of spheres against triangles (their magnitude is
// used); pairs without a closed formula use libccd with its absolute tolerances (1e-16 to 1e-4). Sweeps are not
// supported: FCL's continuous collision needs a list of times, or meshes only.
#pragma once

#include "protocol/contact_query.hpp"
#include "protocol/pair_query.hpp"
#include "scene/scene.hpp"

namespace atwood::fcl_adapter {

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);
PairGap find_gap(const Scene& scene, int a, int b);

}  // namespace atwood::fcl_adapter
