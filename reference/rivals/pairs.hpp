// Contact queries of engines that answer pair by pair.
#pragma once

#include <functional>

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::rivals {

// Calls `ask` for each pair of bodies with shapes, not both fixed, a < b. An std::invalid_argument that it throws makes
// the answer unsupported, with the message after the name of the engine.
ContactAnswer ask_pairs(const char* engine, const Scene& scene,
                        const std::function<void(int a, int b, ContactAnswer&)>& ask);

std::array<Wide, 3> widened(const Real3& v);

// Triangles of a convex shape's hull, anticlockwise seen from outside. Throws std::invalid_argument when it is flat.
std::vector<std::array<int, 3>> hull_of(const Convex& shape);

}  // namespace atwood::rivals
