#include "integrators/responses.hpp"

#include <algorithm>

#include "integrators/catalogue.hpp"

namespace atwood {

const MethodInfo* find_response_in(const std::vector<MethodInfo>& responses, const std::string& name) {
  const auto found = std::ranges::find(responses, "+" + name, &MethodInfo::id);
  return found == responses.end() ? nullptr : &*found;
}

Result<Settings> settings_of_response(const MethodInfo& response, const MethodId& id) {
  Settings own;
  for (const auto& [name, value] : id.overrides)
    if (response.settings.count(name) > 0) own[name] = value;
  return merged_settings(response, own);
}

MethodId without_settings_of(const MethodInfo& response, const MethodId& id) {
  const MethodInfo* scheme = find_integrator(id.scheme);
  MethodId left = id;
  if (scheme != nullptr)
    std::erase_if(left.overrides, [&](const auto& entry) {
      return response.settings.count(entry.first) > 0 && scheme->settings.count(entry.first) == 0;
    });
  return left;
}

}  // namespace atwood
