// Where convex bodies overlap, by libccd 2.1 in double: ccdGJKPenetration (GJK and the expanding polytope) with its own
// tolerances (CCD_INIT: 1e-4 of the polytope, relative) and at most 1000 iterations, where CCD_INIT would leave them
// endless. One point a pair. It compares squares of lengths with numbers that have no unit: bodies of millimetres are
// below them. Planes and meshes it does not know; of compounds each box is asked.
#pragma once

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::libccd {

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);

}  // namespace atwood::libccd
