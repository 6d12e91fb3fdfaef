// Contact queries of engines that are asked pair by pair.
#pragma once

#include <functional>

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::rivals {

// `ask` for each pair of bodies with shapes, not both fixed, a < b; what it throws as std::invalid_argument makes the
// answer unsupported, with `engine` before it.
ContactAnswer ask_pairs(const char* engine, const Scene& scene,
                        const std::function<void(int a, int b, ContactAnswer&)>& ask);

std::array<Wide, 3> widened(const Real3& v);

// Triangles of a convex shape's hull, each anticlockwise from outside. Throws std::invalid_argument where it is flat.
std::vector<std::array<int, 3>> hull_of(const Convex& shape);

}  // namespace atwood::rivals
