#include "rivals/tuned.hpp"

#include <cstdint>

#include <nlohmann/json.hpp>

extern const char* const atwood_tuned_json;

namespace atwood::rivals {
namespace {

SettingValue value_of(const nlohmann::json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (value.is_number()) return value.get<double>();
  return value.get<std::string>();
}

}  // namespace

Settings tuned_changes(const std::string& engine, SceneClass scene_class) {
  static const nlohmann::json all = nlohmann::json::parse(atwood_tuned_json);
  Settings changes;
  const auto of_engine = all.find(engine);
  if (of_engine == all.end()) return changes;
  const auto of_class = of_engine->find(to_string(scene_class));
  if (of_class == of_engine->end() || !of_class->contains("settings")) return changes;
  for (const auto& [name, value] : of_class->at("settings").items()) changes[name] = value_of(value);
  return changes;
}

std::string tuned_words(const std::string& engine, SceneClass scene_class) {
  std::string words;
  for (const auto& [name, value] : tuned_changes(engine, scene_class))
    words += (words.empty() ? "" : ", ") + name + "=" + value_words(value);
  return words.empty() ? "the default" : words;
}

}  // namespace atwood::rivals
