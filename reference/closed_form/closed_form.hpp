// Closed forms: one solution a file, its citation first. Each is evaluated twice from the scene's doubles, in quad and
// in long double; the difference, scaled by the ratio of the two unit round-offs, is what the round-off of the quad
// evaluation amounts to, conditioning included, and makes the bar.
#pragma once

#include <string>
#include <vector>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Solves scenario.truth.solution at t = t_end_s k / samples, k = 0..samples. A scene that the named solution does not
// fit is answered with Status::unsupported and what does not fit; an unknown name likewise. Never throws on a scene.
Truth closed_form_truth(const Scenario& scenario, std::int64_t samples);

// The ids that `solution` may name.
std::vector<std::string> closed_form_ids();

}  // namespace atwood
