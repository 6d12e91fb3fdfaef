// JSON text to a Value, through nlohmann-json.
#include <nlohmann/json.hpp>

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "scene/value.hpp"

namespace atwood {
namespace {

// Of a scene, whose members an ordered_json looks through for each new one. A scene of 100 000 bodies made by [[grid]]
// has 5 million values.
constexpr JsonBounds kBounds{.values = 16'000'000, .members = 4096};

Value convert(const nlohmann::ordered_json& node, const std::string& name, int depth) {
  if (depth > kDeepest)
    throw InputError(name + ": found nesting deeper than " + std::to_string(kDeepest) + " levels; expected a scene");
  if (node.is_object()) {
    Value::Table members;
    for (const auto& item : node.items()) members.push_back({item.key(), convert(item.value(), name, depth + 1), {}});
    return members;
  }
  if (node.is_array()) {
    Value::List items;
    items.reserve(node.size());
    for (const auto& child : node) items.push_back(convert(child, name, depth + 1));
    return items;
  }
  if (node.is_string()) return node.get<std::string>();
  if (node.is_boolean()) return node.get<bool>();
  if (node.is_number_unsigned() && node.get<std::uint64_t>() > static_cast<std::uint64_t>(INT64_MAX))
    return node.get<double>();
  if (node.is_number_integer()) return node.get<std::int64_t>();
  if (node.is_number()) return node.get<double>();
  return {};
}

}  // namespace

Value parse_json(std::string_view text, const std::string& name) {
  require_shallow_json(text, name, kBounds);
  try {
    return convert(nlohmann::ordered_json::parse(text), name, 0);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(name + ": not valid JSON: " + error.what() + "; expected a scene as one JSON object");
  }
}

}  // namespace atwood
