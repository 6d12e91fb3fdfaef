// One scene in one MultibodySystem. Conventions met on the way:
//   - a body that rotates has a free mobilizer (a quaternion, rates in the world), a point mass a translation;
//   - forces that Simbody lacks are a Force::Custom: evaluated by the adapter at every rate call, as Simbody's own are;
//   - a step of fixed size still pays for its error estimate, and is taken whatever that says;
//   - contacts: the unilateral ones with a coefficient of restitution belong to SemiExplicitEulerTimeStepper, which is called
//     experimental and traces every step on standard output; the others are compliant and have no such coefficient. So scenes
//     in which bodies can touch are refused.
#pragma once

#include <memory>
#include <set>
#include <string>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::simbody {

std::string version();
Settings settings_of(const std::string& integrator, double accuracy);
std::set<std::string> fixed_settings();
void check_settings(const Settings& settings);  // throws std::invalid_argument
std::string refusal(const Scene& scene);

// What Simbody threw since the last call; empty: nothing.
std::string doubts_since_last_asked();

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe);

}  // namespace atwood::simbody
