// One scene in one mjModel and mjData: motion, contacts, complaints.
//   - contacts are found at a step's beginning; Euler: v += h (M^-1 (f + J^T force)), then x += h v; RK4: four times
//   so;
//   - contacts are soft: a force grows with overlap, so a body at rest lies a little inside the floor;
//   - a state that is not a number makes MuJoCo start the scene afresh with a warning: here the run ends as not finite.
#pragma once

#include <memory>
#include <set>
#include <string>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::mujoco {

Settings default_settings();
Settings tuned_settings();
std::set<std::string> fixed_settings();
void check_settings(const Settings& settings);  // throws std::invalid_argument

// What MuJoCo can't hold beyond what every adapter refuses; empty when it can.
std::string refusal(const Scene& scene, const Settings& settings);

// What MuJoCo warned of since the last call; empty: nothing.
std::string doubts_since_last_asked();

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe);

}  // namespace atwood::mujoco
