// One scene in one World, each body a Skeleton of one BodyNode, each tree of joints one Skeleton (mechanism.hpp).
// Conventions of DART 6.12:
//   - a body that rotates has a FreeJoint, whose velocities are the twist in body axes. DART rotates them with the
//     frame at the end of a step, so that velocity and position are those of the same time, and a spinning body moves
//     straight;
//   - v += h M^-1 f (gyroscopic torque explicit, at the start of the step); contacts are found at the old positions,
//     their impulses from a boxed complementarity problem; then R := R exp(h w), x += h v: attitudes are of first
//     order.
//     Positions store the logarithm of R;
//   - a point mass has a TranslationalJoint; fixed and held bodies are immobile skeletons;
//   - a contact's normal points into its first body, and its force acts on the first;
//   - friction is a pyramid of two axes: the first is a direction of the shape; unless it is set, it is the projection
//     of z, otherwise of x. The setting friction_direction = slip sets it in each step, after contacts are found, along
//     the
//     largest slip velocity of the shape's contacts;
//   - restitution applies to the velocity that contains the step's gravity: from a floor a ball leaves with e (v + g
//     h), if this exceeds 0.1 m/s, a constant of the compiled library; surfaces.hpp describes the laws of pairs;
//   - the constants of contacts (erp, cfm, ...) are global to the process;
//   - assertions are on, and NaN would end the process. The adapter therefore checks forces and velocities first, and
//     ends the run as not finite.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::dartsim {

std::string version();
std::vector<Setting> settings();
Settings stiff();                                              // the changes of the preset of that name
std::optional<Fault> contradiction(const Settings& settings);  // of values that are each in range

// Why DART cannot represent the scene, beyond the refusals of every adapter; none when it can.
std::optional<Fault> refusal(const Scene& scene, const Settings& settings);

// DART's output on standard error and standard output since the last call: number of lines and the first; empty: none.
std::string diagnostics_since_last_call();

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe);

}  // namespace atwood::dartsim
