// Contact queries in units of the size of the bodies, for engines with absolute tolerances.
#pragma once

#include <functional>

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood::rivals {

using ContactTest = std::function<ContactAnswer(const Scene&, const ContactQuery&)>;

// Calls `find` for the scene scaled to the radius of its smallest body and translated so that its first movable body is
// at the origin; converts the answer back to metres. libccd (and FCL and ODE, which call it) and Bullet compare lengths
// with absolute numbers from 1e-16 to 1e-4, which are too large for bodies of millimetres.
ContactTest at_unit_size(ContactTest find);

}  // namespace atwood::rivals
