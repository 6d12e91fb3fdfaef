// A rival, not a part of the engine's narrow phase: boxes by "does an edge of one pass through a face of the other".
// Many a first program tests boxes so, and this one is kept to show what the test misses:
//   - a box wholly within another: no edge passes through any face;
//   - direction and depth: the face that an edge happens to cross need not be that of least penetration, and the depth
//   of the
//     edge's end below it is not the way out. An edge right through a box gives the depth of an end on the far side.
// What it finds is a true hit: two surfaces do cross there.
#pragma once

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood {

// As find_scene_contacts (collision/query.hpp), for scenes of boxes: each crossing is one contact, its point where the
// edge passes through the face, its normal that face's, its depth that of the edge's lower end below it. Not swept.
ContactAnswer find_contacts_by_box_edges(const Scene& scene, const ContactQuery& query);

}  // namespace atwood
