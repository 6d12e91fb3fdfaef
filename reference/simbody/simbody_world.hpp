// One scene in one MultibodySystem. Conventions of Simbody:
//   - a body that rotates has a free mobilizer (a quaternion, angular velocity in world axes), a point mass a
//     translation;
//   - forces that Simbody lacks are a Force::Custom, which the adapter evaluates at every rate call, like Simbody's
//     own;
//   - a step of fixed size still computes the error estimate, and is accepted at any error;
//   - contacts: the Hertz contact of CompliantContactSubsystem between spheres and half-spaces, with the dissipation of
//     Hunt and Crossley, without tensile forces: F = 4/3 E R^1/2 d^3/2 (1 + 3/2 c d'), which is the law `hertz` of a
//     scene
//     with c = 2/3 of its damping. Materials combine as 1/E^2/3 = 1/E_a^2/3 + 1/E_b^2/3 (E_a, E_b as given to Simbody),
//     so
//     that one law for all pairs follows from one material, 2^3/2 E. Its friction creeps below a transition speed, and
//     restitution is not a parameter: scenes with either, or with other shapes, are refused. The unilateral contacts
//     with a coefficient of restitution belong to SemiExplicitEulerTimeStepper, which is experimental and traces every
//     step on standard output.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::simbody {

std::string version();
std::vector<Setting> settings();
std::optional<Fault> contradiction(const Settings& settings);  // of values that are each in range
std::optional<Fault> refusal(const Scene& scene, const Settings& settings);

// Messages of exceptions that Simbody threw since the last call; empty: none.
std::string diagnostics_since_last_call();

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe);

}  // namespace atwood::simbody
