// A scene in words: what is in it, what happens first, who can run it, which truth covers it, what looks odd.
#pragma once

#include <string>
#include <vector>

#include "reports/command_line/command_line.hpp"

namespace atwood {

// Asks the engines for one step each and the truth for its end, a few seconds at most. Lines of at most `width`
// columns.
std::string scene_summary(const Place& place, const Scenario& scenario, const std::vector<Worker>& workers, int width);

// What speaks against the scene as it stands, one sentence each; from its numbers alone.
std::vector<std::string> scene_warnings(const Scenario& scenario);

}  // namespace atwood
