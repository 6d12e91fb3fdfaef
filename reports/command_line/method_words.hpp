// Methods and their settings in words and in JSON, as list and describe print them.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "protocol/method.hpp"

namespace atwood {

nlohmann::ordered_json json_of(const SettingValue& value);
nlohmann::ordered_json method_json(const MethodInfo& info);
std::string claims_words(const MethodInfo& info);  // "point-mass 4, rotation 4", "no claim"
// A line a setting: its default, what it takes and what it means.
std::string settings_text(const MethodInfo& info, std::size_t width);

// Names of the TOML files of a folder, without their ending, sorted.
std::vector<std::string> file_stems(const std::string& folder);

}  // namespace atwood
