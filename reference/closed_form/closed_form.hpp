// Closed forms: one solution per file, with its citation at the top. Each is evaluated from the scene's doubles in quad
// and in long double. The difference, scaled by the ratio of the two unit round-offs, estimates the round-off error of
// the quad evaluation, including the conditioning of the motion; the bar is a multiple of it.
#pragma once

#include <string>
#include <vector>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Evaluates scenario.truth.solution at t = t_end_s k / samples, k = 0..samples. A scene that the solution does not
// cover, or an unknown solution, is answered with Status::unsupported and a reason. Where the outcome of an impact is
// not decided, the reason has the time, and the samples and events before it are certified. Never throws on a scene.
Truth closed_form_truth(const Scenario& scenario, std::int64_t samples);

// The ids that `solution` may name.
std::vector<std::string> closed_form_ids();

}  // namespace atwood
