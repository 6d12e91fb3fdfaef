// A TOML value as a message quotes it.
#pragma once

#include <string>

#include "scene/toml_parser.hpp"

#include "protocol/sample.hpp"

namespace atwood {

// "text", 1.5, true, "a list of 2", "a table"; dates and times as "a date or time".
inline std::string found_text(const toml::node& node) {
  if (const auto text = node.value_exact<std::string>()) return "\"" + *text + "\"";
  if (const auto flag = node.value_exact<bool>()) return *flag ? "true" : "false";
  if (const auto whole = node.value_exact<std::int64_t>()) return std::to_string(*whole);
  if (const auto real = node.value_exact<double>()) return format_double(*real);
  if (const toml::array* list = node.as_array())
    return list->empty() ? "an empty list" : "a list of " + std::to_string(list->size());
  return node.is_table() ? "a table" : "a date or time";
}

}  // namespace atwood
