// One scene in one dWorld. Conventions met on the way:
//   - angular velocity is in world axes; samples turn it to body axes;
//   - the inertia is given whole (dMass), off-diagonal terms too;
//   - shapes: see shapes.hpp;
//   - a contact's normal points into its first body; restitution and friction come with every contact (dSurface);
//   - mu is a force unless dContactApprox1 makes it a coefficient: always set, else friction isn't the scene's;
//   - contacts are found at a step's start, then v += h F/m with contacts, then x += h v.
#pragma once

#include <memory>
#include <set>
#include <string>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::ode {

Settings default_settings();
std::set<std::string> fixed_settings();
void check_settings(const Settings& settings);  // throws std::invalid_argument

// What ODE can't hold beyond what every adapter refuses; empty when it can.
std::string refusal(const Scene& scene);

// What ODE's own messages said since the last call: "ODE complained 3 times, first: LCP internal error"; empty:
// nothing.
std::string doubts_since_last_asked();

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe);

}  // namespace atwood::ode
