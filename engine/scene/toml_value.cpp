// TOML text to a Value, through toml++.
#include <toml++/toml.h>

#include <algorithm>

#include "scene/files.hpp"
#include "scene/value.hpp"

namespace atwood {
namespace {

std::string at(const std::string& name, Place place) {
  return name + ":" + std::to_string(place.line) + ":" + std::to_string(place.column) + ": ";
}

Place place_of(const toml::source_region& region) {
  return {static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

bool before(Place a, Place b) { return a.line != b.line ? a.line < b.line : a.column < b.column; }

Value convert(const toml::node& node, const std::string& name, int depth) {
  const Place place = place_of(node.source());
  if (depth > kDeepest)
    throw InputError(at(name, place) + "found nesting deeper than " + std::to_string(kDeepest) +
                     " levels; expected a scenario");
  Value value;
  if (const auto* table = node.as_table()) {
    Value::Table members;
    for (const auto& [key, child] : *table)
      members.push_back({std::string(key.str()), convert(child, name, depth + 1), place_of(key.source())});
    // toml++ sorts by key; the file's own order is the one people mean.
    std::stable_sort(members.begin(), members.end(),
                     [](const Member& a, const Member& b) { return before(a.place, b.place); });
    value = Value(std::move(members));
  } else if (const auto* array = node.as_array()) {
    Value::List items;
    for (const auto& child : *array) items.push_back(convert(child, name, depth + 1));
    value = Value(std::move(items));
  } else if (const auto* text = node.as_string()) {
    value = Value(text->get());
  } else if (const auto* integer = node.as_integer()) {
    value = Value(integer->get());
  } else if (const auto* real = node.as_floating_point()) {
    value = Value(real->get());
  } else if (const auto* boolean = node.as_boolean()) {
    value = Value(boolean->get());
  } else {
    throw InputError(at(name, place) + "found a date or time; expected a number, text, list or table");
  }
  value.place = place;
  return value;
}

}  // namespace

Value parse_toml(std::string_view text, const std::string& name) {
  try {
    return convert(toml::parse(text, name), name, 0);
  } catch (const toml::parse_error& error) {
    throw InputError(at(name, place_of(error.source())) + "found what is no TOML (" + std::string(error.description()) +
                     "); expected a scenario in TOML");
  }
}

}  // namespace atwood
