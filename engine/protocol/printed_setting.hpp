// Settings that cannot be changed but decide results: printed beside the others, with a range of one value.
#pragma once

#include <string>
#include <utility>

#include "protocol/setting.hpp"

namespace atwood {

inline Setting printed(std::string name, SettingValue value, std::string doc = "Printed; it cannot be changed.") {
  SettingRange range;
  if (const auto* integer = std::get_if<std::int64_t>(&value))
    range = between(static_cast<double>(*integer), static_cast<double>(*integer));
  else if (const auto* real = std::get_if<double>(&value)) range = between(*real, *real);
  else range = one_of({value_words(value)});
  return {std::move(name), std::move(value), {std::move(range), std::move(doc)}};
}

// Has the rule of a setting one value?
inline bool is_printed(const SettingRule& rule) {
  return rule.range.choices.size() == 1 || (rule.range.choices.empty() && rule.range.least == rule.range.most);
}

}  // namespace atwood
