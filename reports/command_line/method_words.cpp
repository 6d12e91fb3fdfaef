#include "reports/command_line/method_words.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "protocol/printed_setting.hpp"
#include "reports/command_line/manual.hpp"

namespace atwood {
namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

std::string without_id(const std::invalid_argument& error, const std::string& id) {
  const std::string text = error.what(), prefix = "method `" + id + "`: ";
  return text.starts_with(prefix) ? text.substr(prefix.size()) : text;
}

json json_of(const SettingValue& value) {
  if (const auto* real = std::get_if<double>(&value); real != nullptr && !std::isfinite(*real))
    return format_double(*real);  // JSON has no infinity
  return std::visit([](const auto& v) { return json(v); }, value);
}

std::string claims_words(const MethodInfo& info) {
  std::string text;
  for (const auto& [motion, order] : info.claimed_order)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", motion, order);
  return text.empty() ? "no claim" : text;
}

json method_json(const MethodInfo& info) {
  json settings = json::object();
  for (const auto& [name, value] : info.settings) settings[name] = json_of(value);
  json rules = json::object();
  for (const auto& [name, rule] : info.rules) {
    const auto standard = info.settings.find(name);
    if (standard == info.settings.end()) continue;
    rules[name] = {{"doc", rule.doc}, {"unit", rule.unit}, {"takes", range_words(standard->second, rule.range)}};
  }
  return {{"id", info.id},
          {"doc", info.doc},
          {"formula", info.formula},
          {"source", info.source},
          {"claimed_order", info.claimed_order},
          {"adaptive", info.adaptive},
          {"settings", settings},
          {"setting_rules", rules}};
}

std::string settings_text(const MethodInfo& info, std::size_t width) {
  std::string text;
  for (const auto& [name, value] : info.settings) {
    text += fmt::format("    {} = {}\n", name, value_words(value));
    const auto rule = info.rules.find(name);
    if (rule == info.rules.end()) continue;
    const std::string unit = rule->second.unit.empty() ? "" : " [" + rule->second.unit + "]";
    const std::string takes =
        is_printed(rule->second) ? "" : fmt::format(" Takes {}{}.", range_words(value, rule->second.range), unit);
    text += wrapped(rule->second.doc + takes, 8, width);
  }
  return text;
}

std::vector<std::string> file_stems(const std::string& folder) {
  std::vector<std::string> stems;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".toml") stems.push_back(entry.path().stem().string());
  }
  std::sort(stems.begin(), stems.end());
  return stems;
}

}  // namespace atwood
