// A baseline for comparison, not a part of the engine's narrow phase: boxes by the test "does an edge of one pass
// through a face of the other". It is a common first attempt and is kept to show what it misses:
//   - a box inside another: no edge passes through any face;
//   - normal and depth: the face that an edge crosses need not be that of least penetration, and the depth of the
//     edge's end below it is not the penetration depth. An edge through the whole box gives the depth of an end
//     beyond the far side.
// A contact that it reports is a true one: two surfaces cross there.
#pragma once

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood {

// As find_scene_contacts (collision/query.hpp), for scenes of boxes: each crossing is one contact, its point where the
// edge passes through the face, its normal that face's, its depth that of the edge's lower end below it. Unsupported,
// with the reason, for swept queries and for other shapes.
ContactAnswer find_contacts_by_box_edges(const Scene& scene, const ContactQuery& query);

}  // namespace atwood
