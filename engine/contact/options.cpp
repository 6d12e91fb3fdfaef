#include "contact/options.hpp"

#include <algorithm>

#include "integrators/catalogue.hpp"

namespace atwood {

namespace {

std::vector<MethodInfo> make_responses() {
  MethodInfo impulse;
  impulse.id = "+impulse";
  impulse.doc = "Time stepping: contacts found once a step, velocities solved so that no contact approaches.";
  impulse.source = "Moreau (1988); Stewart and Trinkle (1996)";
  MethodInfo event;
  event.id = "+event";
  event.doc = "Impacts located to round-off on the method's own flow, lasting contacts as constrained motion between them.";
  event.source = "Hairer, Norsett, Wanner (1993), II.6; Pfeiffer and Glocker (1996)";
  MethodInfo penalty;
  penalty.id = "+penalty";
  penalty.doc = "Contacts as springs and dashpots, forces like any other.";
  penalty.source = "Cundall and Strack (1979); Hunt and Crossley (1975)";
  return {impulse, event, penalty};
}

}  // namespace

const std::vector<MethodInfo>& contact_responses() {
  static const std::vector<MethodInfo> all = make_responses();
  return all;
}

const MethodInfo* find_response(const std::string& name) {
  const auto& all = contact_responses();
  const auto found = std::find_if(all.begin(), all.end(), [&](const MethodInfo& info) { return info.id == "+" + name; });
  return found == all.end() ? nullptr : &*found;
}

Settings response_settings(const MethodId& id, std::string& why) {
  const MethodInfo* response = find_response(id.response);
  if (response == nullptr) return {};
  Settings own;
  for (const auto& [name, value] : id.overrides)
    if (response->settings.count(name)) own[name] = value;
  return merged_settings(*response, own, why);
}

MethodId integrator_part(const MethodId& id) {
  const MethodInfo* response = find_response(id.response);
  const MethodInfo* scheme = find_integrator(id.scheme);
  if (response == nullptr || scheme == nullptr) return id;
  MethodId left = id;
  std::erase_if(left.overrides, [&](const auto& entry) {
    return response->settings.count(entry.first) > 0 && scheme->settings.count(entry.first) == 0;
  });
  return left;
}

}  // namespace atwood
