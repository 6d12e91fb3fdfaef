// Joints and ropes of a scene in words, for `describe`.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood {

// A line for each joint, of many joints the first ones and how many more there are: its kind, what it ties together,
// its start, limits, what prescribes it, whether it closes a loop, and the forces along it.
std::vector<std::string> joints_words(const Scene& scene);
std::vector<std::string> ropes_words(const Scene& scene);

}  // namespace atwood
