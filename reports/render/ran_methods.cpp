#include "ran_methods.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

namespace atwood {
namespace {

const MethodInfo* with_id(const std::vector<MethodInfo>& methods, const std::string& id) {
  const auto found =
      std::find_if(methods.begin(), methods.end(), [&](const MethodInfo& info) { return info.id == id; });
  return found == methods.end() ? nullptr : &*found;
}

// A setting that both a scheme and its response have is the id's for both.
Settings with_overrides(const MethodInfo& info, const Settings& overrides) {
  Settings merged = info.settings;
  for (const auto& [name, value] : overrides)
    if (merged.contains(name)) merged[name] = value;
  return merged;
}

// The id's tolerances and scalar stand in the settings' place, where the engine prints such.
void apply_id(Settings& settings, const MethodId& id) {
  const auto set = [&](const char* name, SettingValue value) {
    if (settings.contains(name)) settings[name] = std::move(value);
  };
  if (id.rtol) set("rtol", *id.rtol);
  if (id.atol) set("atol", *id.atol);
  if (!id.scalar.empty()) set("scalar", id.scalar);
}

// No engine, where none of the report's lists the method: a run that was recorded elsewhere.
RanMethod find_method(const std::vector<Engine>& engines, const std::string& text) {
  RanMethod made;
  made.id = text;
  MethodId id;
  try {
    id = parse_method_id(text);
  } catch (const std::invalid_argument&) {
    return made;
  }
  for (const Engine& engine : engines) {
    if (engine.name != id.engine) continue;
    made.engine = &engine;
    made.scheme = with_id(engine.methods, id.engine + "/" + id.scheme);
    if (made.scheme == nullptr) continue;  // a query such as "fcl/contacts" is not a scheme
    made.settings = with_overrides(*made.scheme, id.overrides);
    apply_id(made.settings, id);
    if (!id.response.empty()) made.response = with_id(engine.responses, "+" + id.response);
    if (made.response != nullptr) made.response_settings = with_overrides(*made.response, id.overrides);
    for (const auto& [name, value] : id.overrides)
      if (!made.response_settings.contains(name)) made.settings[name] = value;
    break;
  }
  return made;
}

}  // namespace

std::vector<RanMethod> ran_methods(const std::vector<Engine>& engines, const std::vector<Row>& rows) {
  std::vector<RanMethod> ran;
  std::set<std::string> seen;
  for (const Row& row : rows) {
    if (row.status == Status::unsupported || row.status == Status::not_built || seen.contains(row.method)) continue;
    seen.insert(row.method);
    RanMethod method = find_method(engines, row.method);
    if (method.engine != nullptr) ran.push_back(std::move(method));
  }
  return ran;
}

std::vector<Engine> engines_that_ran(const std::vector<Engine>& engines, const std::vector<RanMethod>& ran) {
  std::vector<Engine> kept;
  for (const Engine& engine : engines) {
    std::set<const MethodInfo*> wanted;
    for (const RanMethod& method : ran)
      if (method.engine == &engine) wanted.insert({method.scheme, method.response});
    if (wanted.empty()) continue;
    Engine one{engine.name, engine.version, engine.scalar, {}, nullptr};
    for (const MethodInfo& info : engine.methods)
      if (wanted.contains(&info)) one.methods.push_back(info);
    for (const MethodInfo& info : engine.responses)
      if (wanted.contains(&info)) one.responses.push_back(info);
    kept.push_back(std::move(one));
  }
  return kept;
}

std::string setting_words(const SettingValue& value) {
  return std::visit([](const auto& held) { return fmt::format("{}", held); }, value);
}

std::string settings_words(const Settings& settings) {
  std::string words;
  for (const auto& [name, value] : settings) words += (words.empty() ? "" : ", ") + name + " = " + setting_words(value);
  return words;
}

}  // namespace atwood
