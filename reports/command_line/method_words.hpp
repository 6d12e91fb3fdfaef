// Methods and their settings as text and as JSON, as `list` and `describe` print them.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "protocol/method.hpp"

namespace atwood {

nlohmann::ordered_json json_of(const SettingValue& value);
nlohmann::ordered_json method_json(const MethodInfo& info);
std::string claims_words(const MethodInfo& info);  // "point-mass 4, rotation 4", "no claim"
// A line for each setting: default, range or choices, and meaning.
std::string settings_text(const MethodInfo& info, std::size_t width);

// The message of parse_method_id without the id, for messages that begin with the id.
std::string without_id(const std::invalid_argument& error, const std::string& id);

// Names of the TOML files of a folder, without their ending, sorted.
std::vector<std::string> file_stems(const std::string& folder);

}  // namespace atwood
