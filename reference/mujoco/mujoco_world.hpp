// One scene in one mjModel and mjData: motion, contacts, warnings.
//   - contacts are found at the start of a step; Euler: v += h (M^-1 (f + J^T force)), then x += h v; RK4 evaluates
//     them at each of its four stages;
//   - contacts are soft: a force grows with the overlap, so that a body at rest overlaps the floor a little;
//   - MuJoCo resets a scene whose state is NaN, with a warning; the adapter then ends the run as not finite.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::mujoco {

std::vector<Setting> settings();
Settings stiff();  // the changes of the preset of that name

// Why MuJoCo cannot represent the scene, beyond the refusals of every adapter; none when it can.
std::optional<Fault> refusal(const Scene& scene, const Settings& settings);

// MuJoCo's warnings since the last call: their number and the first; empty: none.
std::string diagnostics_since_last_call();

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe);

}  // namespace atwood::mujoco
