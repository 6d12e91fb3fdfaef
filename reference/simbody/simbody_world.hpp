// One scene in one MultibodySystem. Conventions met on the way:
//   - a body that rotates has a free mobilizer (a quaternion, rates in the world), a point mass a translation;
//   - forces that Simbody lacks are a Force::Custom: evaluated by the adapter at every rate call, as Simbody's own are;
//   - a step of fixed size still pays for its error estimate, and is taken whatever that says;
//   - contacts: CompliantContactSubsystem's Hertz contact between spheres and half-spaces, with the dissipation of Hunt
//   and
//     Crossley, never pulling: F = 4/3 E R^1/2 d^3/2 (1 + 3/2 c d'), the law `hertz` of a scene with c = 2/3 of its
//     damping. Materials mix as 1/E^2/3 = 1/E_a^2/3 + 1/E_b^2/3 (E_a, E_b as they are given to Simbody), so one law for
//     all pairs comes of one material, 2^3/2 E. Its friction creeps below a transition speed, and restitution is no
//     parameter: scenes with either, or with other shapes, are refused. The unilateral contacts with a coefficient of
//     restitution belong to SemiExplicitEulerTimeStepper, which is called experimental and traces every step on
//     standard output.
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
