// Contact queries in the units that an engine is at its best in.
#pragma once

#include <functional>

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::rivals {

using ContactTest = std::function<ContactAnswer(const Scene&, const ContactQuery&)>;

// `find` asked about the scene with its smallest body's radius as the unit of length and its first movable body at the
// origin; the answer in metres and where it was. libccd (and FCL and ODE, which call it) and Bullet compare with
// numbers that have no unit, 1e-16 to 1e-4: millimetres are below them.
ContactTest at_unit_size(ContactTest find);

}  // namespace atwood::rivals
