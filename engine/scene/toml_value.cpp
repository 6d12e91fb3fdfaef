// TOML text to a Value, through toml++.
#include "scene/toml_parser.hpp"

#include <algorithm>

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "scene/value.hpp"

namespace atwood {
namespace {

std::string at(const std::string& name, SourceLocation location) {
  return name + ":" + std::to_string(location.line) + ":" + std::to_string(location.column) + ": ";
}

SourceLocation location_of(const toml::source_region& region) {
  return {static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

bool before(SourceLocation a, SourceLocation b) { return a.line != b.line ? a.line < b.line : a.column < b.column; }

Value convert(const toml::node& node, const std::string& name, int depth) {
  const SourceLocation location = location_of(node.source());
  if (depth > kDeepest)
    throw InputError(at(name, location) + "found nesting deeper than " + std::to_string(kDeepest) +
                     " levels; expected a scenario");
  Value value;
  if (const auto* table = node.as_table()) {
    Value::Table members;
    for (const auto& [key, child] : *table)
      members.push_back({std::string(key.str()), convert(child, name, depth + 1), location_of(key.source())});
    // toml++ sorts by key; the file's own order is the one people mean.
    std::stable_sort(members.begin(), members.end(),
                     [](const Member& a, const Member& b) { return before(a.location, b.location); });
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
    throw InputError(at(name, location) + "found a date or time; expected a number, text, list or table");
  }
  value.location = location;
  return value;
}

// The length of the UTF-8 sequence at the front of `text`; 0 when it is none (Unicode 15, table 3-7).
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const auto continues = [&](std::size_t i) { return (byte(i) & 0xc0u) == 0x80u; };
  const unsigned lead = byte(0), second = byte(1);
  if (lead < 0x80) return 1;
  if (lead >= 0xc2 && lead <= 0xdf) return continues(1) ? 2 : 0;
  if (lead >= 0xe0 && lead <= 0xef) {
    const bool shortest = lead != 0xe0 || second >= 0xa0, no_surrogate = lead != 0xed || second < 0xa0;
    return shortest && no_surrogate && continues(1) && continues(2) ? 3 : 0;
  }
  if (lead >= 0xf0 && lead <= 0xf4) {
    const bool in_range = (lead != 0xf0 || second >= 0x90) && (lead != 0xf4 || second < 0x90);
    return in_range && continues(1) && continues(2) && continues(3) ? 4 : 0;
  }
  return 0;
}

// For bytes that are not UTF-8, toml++ reports a place one character too early.
void require_utf8(std::string_view text, const std::string& name) {
  SourceLocation location{1, 1};
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    if (length == 0)
      throw InputError(at(name, location) +
                       "found bytes that are not UTF-8; expected a scenario in TOML, encoded in UTF-8");
    location = text.front() == '\n' ? SourceLocation{location.line + 1, 1}
                                    : SourceLocation{location.line, location.column + 1};
    text.remove_prefix(length);
  }
}

}  // namespace

Value parse_toml(std::string_view text, const std::string& name) {
  require_utf8(text, name);
  require_shallow_toml(text, name);
  try {
    return convert(toml::parse(text, name), name, 0);
  } catch (const toml::parse_error& error) {
    throw InputError(at(name, location_of(error.source())) + "not valid TOML: " + std::string(error.description()) +
                     "; expected a scenario in TOML");
  }
}

std::string place_of_key(const std::string& path, std::string_view table, std::string_view key) {
  const Value document = parse_toml(read_input_file(path, "a scenario file (TOML)", largest::kScenario), path);
  const Value* inside = table.empty() ? &document : document.find(table);
  const Value* value = inside ? inside->find(key) : nullptr;
  return value ? path + ":" + std::to_string(value->location.line) + ":" + std::to_string(value->location.column)
               : path;
}

}  // namespace atwood
