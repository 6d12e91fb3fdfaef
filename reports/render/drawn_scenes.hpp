// What the report draws of its scenes: shapes at the start and the motion of the truth.
#pragma once

#include <vector>

#include "json_text.hpp"
#include "scene/scene.hpp"
#include "validation/study/truth_paths.hpp"

namespace atwood {

// An array with an object for each path: id, t_end, the scene as a playback page has it, and `poses`: for each body an
// object {p, q} of its motion, sample by sample, or null where it does not move; `methods`, where some are drawn beside
// the truth: id, steps, and for each body {p, r}, its errors of position and attitude.
void append_drawn_scenes(JsonText& json, const std::vector<Scenario>& scenarios, const std::vector<TruthPath>& paths);

}  // namespace atwood
