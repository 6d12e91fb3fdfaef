// Where bodies touch, and how far apart they are, by FCL: fcl::collide with its own solver settings (contacts on, at
// most 64), fcl::distance with nearest points. A plane is a half space, a rectangle a box of zero thickness, a mesh a
// surface in a tree of oriented boxes.
//
// What is FCL's own: no distance to a half space; depths below zero of spheres against triangles (their size is taken);
// pairs without a formula of theirs go to libccd, with its numbers without a unit (1e-16 to 1e-4). Not asked for
// sweeps: its continuous collision takes a list of times or meshes alone.
#pragma once

#include "protocol/contact_query.hpp"
#include "protocol/pair_query.hpp"
#include "scene/scene.hpp"

namespace atwood::fcl_adapter {

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);
PairGap find_gap(const Scene& scene, int a, int b);

}  // namespace atwood::fcl_adapter
