// Overlaps of convex bodies by libccd 2.1 in double: ccdGJKPenetration (GJK and the expanding polytope) with its own
// tolerances (CCD_INIT: 1e-4 of the polytope, relative) and at most 1000 iterations (CCD_INIT has no limit). One point
// per pair. Its absolute tolerances on squares of lengths are too large for bodies of millimetres. It has no planes and
// meshes; each box of a compound is queried.
#pragma once

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::libccd {

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query);

}  // namespace atwood::libccd
