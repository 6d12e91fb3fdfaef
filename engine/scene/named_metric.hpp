// The metric that a scenario is about.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood {

// `metric` of the scenario's file, with which reports open it. Nothing that is simulated, measured or judged depends on
// it, so that it is read for reports, and for the search of tuned presets, and is not part of the scenario. Empty: the
// file names none, or the scenario came by JSON, or its file is gone or no longer one.
std::string named_metric(const Scenario& scenario);

}  // namespace atwood
