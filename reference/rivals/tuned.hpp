// The `tuned` presets: the settings that `atwood tune` found for each engine and class of scene, in
// reference/rivals/tuned.json. The file is embedded when the adapters are built.
#pragma once

#include <string>

#include "protocol/method.hpp"
#include "rivals/scene_class.hpp"

namespace atwood::rivals {

// Changes to the default settings; empty when the search found none: tuned is then the default.
Settings tuned_changes(const std::string& engine, SceneClass scene_class);
// The same as text to print beside the settings: "erp=0.1, iterations=50", or "the default".
std::string tuned_words(const std::string& engine, SceneClass scene_class);

}  // namespace atwood::rivals
