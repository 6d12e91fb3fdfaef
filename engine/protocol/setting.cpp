#include "protocol/setting.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "protocol/method.hpp"
#include "protocol/printed_setting.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace {

constexpr std::array kKinds{"true or false", "a whole number", "a number", "a word"};

bool inside(double value, const SettingRange& range) {
  const bool high_enough = range.least_excluded ? value > range.least : value >= range.least;
  const bool low_enough = range.most_excluded ? value < range.most : value <= range.most;
  return high_enough && low_enough;  // NaN is neither
}

std::string number_words(double value) {
  if (std::abs(value) < 1e7 && value == std::floor(value)) return std::to_string(static_cast<std::int64_t>(value));
  const std::string text = format_double(value);
  return text.ends_with(".0") ? text.substr(0, text.size() - 2) : text;
}

std::string bounds_words(const SettingRange& range) {
  const bool least = range.least > -std::numeric_limits<double>::infinity();
  const bool most = range.most < std::numeric_limits<double>::infinity();
  if (least && most && !range.least_excluded && !range.most_excluded)
    return " from " + number_words(range.least) + " to " + number_words(range.most);
  std::string words;
  if (least) words += (range.least_excluded ? " above " : " of at least ") + number_words(range.least);
  if (most)
    words += (least ? " and" : "") +
             std::string(range.most_excluded ? " below "
                         : least             ? " at most "
                                             : " of at most ") +
             number_words(range.most);
  return words;
}

// "one of a, b, c": what an id can set.
std::string changeable(const MethodInfo& info) {
  std::string names;
  for (const auto& [name, standard] : info.settings) {
    const auto rule = info.rules.find(name);
    const bool printed_alone = name == "scalar" || (rule != info.rules.end() && is_printed(rule->second));
    if (!printed_alone) names += (names.empty() ? "" : ", ") + name;
  }
  return names.empty() ? "none: it has no settings" : "one of " + names;
}

}  // namespace

SettingRange between(double least, double most) { return {.least = least, .most = most}; }
SettingRange strictly_between(double least, double most) {
  return {.least = least, .most = most, .least_excluded = true, .most_excluded = true};
}
SettingRange at_least(double least) { return {.least = least}; }
SettingRange above(double least) { return {.least = least, .least_excluded = true}; }
SettingRange one_of(std::vector<std::string> choices) { return {.choices = std::move(choices)}; }

std::string range_words(const SettingValue& standard, const SettingRange& range) {
  if (!range.choices.empty()) {
    std::string words = range.choices.front();
    for (std::size_t i = 1; i < range.choices.size(); ++i)
      words += (i + 1 == range.choices.size() ? " or " : ", ") + range.choices[i];
    return words;
  }
  const bool number = std::holds_alternative<std::int64_t>(standard) || std::holds_alternative<double>(standard);
  if (number && range.least == range.most) return number_words(range.least);
  return kKinds[standard.index()] + (number ? bounds_words(range) : "");
}

std::string value_words(const SettingValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
  if (const auto* real = std::get_if<double>(&value)) return format_double(*real);
  return std::get<std::string>(value);
}

Result<SettingValue> checked_value(const std::string& owner, const std::string& name, const SettingValue& standard,
                                   const SettingRule* rule, const SettingValue& value) {
  const SettingRange range = rule != nullptr ? rule->range : SettingRange{};
  const auto fault = [&] {
    return Fault{owner + ": `" + name + "` is `" + value_words(value) + "`; expected " + range_words(standard, range)};
  };
  SettingValue taken = value;
  if (std::holds_alternative<double>(standard) && std::holds_alternative<std::int64_t>(value))
    taken = static_cast<double>(std::get<std::int64_t>(value));
  if (taken.index() != standard.index()) return fault();
  if (const auto* integer = std::get_if<std::int64_t>(&taken); integer && !inside(static_cast<double>(*integer), range))
    return fault();
  if (const auto* real = std::get_if<double>(&taken); real && !inside(*real, range)) return fault();
  if (!range.choices.empty() &&
      std::find(range.choices.begin(), range.choices.end(), value_words(taken)) == range.choices.end())
    return fault();
  return taken;
}

void declare_settings(MethodInfo& info, const std::vector<Setting>& table) {
  for (const Setting& setting : table) {
    info.settings[setting.name] = setting.standard;
    info.rules[setting.name] = setting.rule;
  }
}

Result<Settings> merged_settings(const MethodInfo& info, const Settings& overrides) {
  Settings merged = info.settings;
  for (const auto& [name, value] : overrides) {
    const auto known = merged.find(name);
    if (known == merged.end()) return Fault{info.id + " has no setting `" + name + "`; expected " + changeable(info)};
    if (name == "scalar")
      return Fault{info.id + ": `scalar` is not set in braces; expected it behind @, as in " + info.id + "@" +
                   value_words(value)};
    const auto rule = info.rules.find(name);
    const Result<SettingValue> taken =
        checked_value(info.id, name, known->second, rule == info.rules.end() ? nullptr : &rule->second, value);
    if (!taken) return taken.fault();
    known->second = *taken;
  }
  return merged;
}

}  // namespace atwood
