// One scene in one World, each body a Skeleton of one BodyNode. Conventions met on the way:
//   - a body that rotates hangs on a FreeJoint, whose velocities are the twist in body axes; DART 6.12 turns them with
//   the
//     frame at the end of a step, so velocity belongs to the same instant as position, and a spinning body flies
//     straight;
//   - v += h M^-1 f (gyroscopic torque explicit, at the step's beginning), contacts are found at the old positions,
//   impulses
//     by a boxed complementarity problem, then R := R exp(h w), x += h v: attitudes are of first order. Positions store
//     the logarithm of R;
//   - a point mass hangs on a TranslationalJoint; fixed and held bodies are immobile skeletons;
//   - a contact's normal points into its first body and its force is on the first;
//   - friction is a pyramid of two axes: the first is a direction of the shape, unset along the projection of z, else
//   of x.
//     The setting friction_direction `slip` gives it anew each step, once contacts are known, along the fastest slip
//     among the shape's contacts;
//   - restitution is of the velocity that already has the step's gravity in it: off a floor a ball leaves with e (v + g
//   h).
//     It acts where that exceeds 0.1 m/s, fixed when DART was compiled; surfaces.hpp says how the pair's law gets
//     there;
//   - the constants of contacts (erp, cfm, ...) are global to the process;
//   - assertions are on: what would not be a number ends the process. So the adapter looks at forces and speeds first,
//   and
//     ends the run as not finite.
#pragma once

#include <memory>
#include <set>
#include <string>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::dartsim {

std::string version();
Settings default_settings();
Settings tuned_settings();
std::set<std::string> fixed_settings();
void check_settings(const Settings& settings);  // throws std::invalid_argument

// What DART can't hold beyond what every adapter refuses; empty when it can.
std::string refusal(const Scene& scene, const Settings& settings);

// What DART wrote on standard error and output since the last call; empty: nothing.
std::string doubts_since_last_asked();

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe);

}  // namespace atwood::dartsim
