// One scene in one dWorld. Conventions of ODE:
//   - angular velocity is in world axes; samples convert it to body axes;
//   - the inertia is given with its off-diagonal elements (dMass);
//   - shapes: see shapes.hpp;
//   - a contact's normal points into its first body; restitution and friction belong to each contact (dSurface);
//   - mu is a force unless dContactApprox1 makes it a coefficient, as in the scene: it is always set;
//   - joints: see joints.hpp;
//   - contacts are found at the start of a step, then v += h F/m with contact forces, then x += h v.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::ode {

std::vector<Setting> settings();

// Why ODE cannot represent the scene, beyond the refusals of every adapter; none when it can.
std::optional<Fault> refusal(const Scene& scene, const Settings& settings);

// ODE's messages since the last call: "ODE printed 3 messages, first: LCP internal error"; empty: none.
std::string diagnostics_since_last_call();

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe);

}  // namespace atwood::ode
