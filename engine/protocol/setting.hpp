// The settings of a method: name, type, range or choices, unit, meaning and default, declared in one table. Ids
// are checked against that table without running anything.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "protocol/fault.hpp"

namespace atwood {

using SettingValue = std::variant<bool, std::int64_t, double, std::string>;
using Settings = std::map<std::string, SettingValue>;  // by name

// Which values a setting takes. Its type is that of its default.
struct SettingRange {
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();  // numbers
  bool least_excluded = false, most_excluded = false;
  std::vector<std::string> choices = {};  // of words; empty: any word
};
SettingRange between(double least, double most);  // both ends included
SettingRange strictly_between(double least, double most);
SettingRange at_least(double least);
SettingRange above(double least);
SettingRange one_of(std::vector<std::string> choices);

struct SettingRule {
  SettingRange range = {};
  std::string doc = {}, unit = {};  // unit: SI, as in "kg/s", "N s/m"; empty: a pure number, a word, a flag
  bool needs_tolerance = false;     // it acts in runs with a tolerance alone
};
using SettingRules = std::map<std::string, SettingRule>;  // by name

struct Setting {
  std::string name;
  SettingValue standard;  // the default
  SettingRule rule = {};
};

// "a whole number from 0 to 1000", "newton, poisson or stronge".
std::string range_words(const SettingValue& standard, const SettingRange& range);
std::string value_words(const SettingValue& value);  // as an id writes it

// `value` as the setting takes it: a whole number where a real one is expected becomes one. Fails for a value of
// another type or outside the range. `owner`: "atwood/rk4", "+impulse". `rule` may be null: the type alone is checked.
Result<SettingValue> checked_value(const std::string& owner, const std::string& name, const SettingValue& standard,
                                   const SettingRule* rule, const SettingValue& value);

}  // namespace atwood
