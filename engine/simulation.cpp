#include "simulation.hpp"

#include <algorithm>
#include <optional>

#include "collision/query.hpp"
#include "contact/event/event.hpp"
#include "contact/options.hpp"
#include "contact/penalty.hpp"
#include "contact/stepping/run.hpp"
#include "fluid/options.hpp"
#include "fluid/run.hpp"
#include "integrators/catalogue.hpp"
#include "integrators/extrapolation.hpp"
#include "protocol/refusal.hpp"
#include "scene/contact_laws.hpp"
#include "scene/joined.hpp"
#include "smooth/run.hpp"
#include "version.hpp"

namespace atwood {
namespace {

// Settings that rule each other out, or that the others leave without effect.
std::optional<Fault> combination_fault(const MethodId& id, const Settings& settings) {
  const auto input = [&](const std::string& why) { return Fault{"atwood/" + id.scheme + ": " + why}; };
  const auto is = [&](const char* name, const char* word) { return std::get<std::string>(settings.at(name)) == word; };
  if (id.scheme == "ias15" && id.overrides.contains("epsilon") && is("criterion", "tolerance"))
    return input("`epsilon` has an effect only with criterion=rein-spiegel or criterion=prs23");
  if (id.scheme != "gbs" || !id.rtol) return {};
  if (is("order", "chosen") && id.overrides.contains("columns"))
    return input("with a tolerance `columns` has an effect only with order=fixed");
  if (is("order", "fixed") && std::get<std::int64_t>(settings.at("columns")) > kMaxFixedColumns)
    return input("with a tolerance order=fixed takes at most " + std::to_string(kMaxFixedColumns) +
                 " columns, for the differences of later ones are lost in round-off and steps become tiny; use "
                 "order=chosen");
  return {};
}

std::optional<Fault> method_fault(const MethodId& id) {
  const auto input = [](const std::string& why) { return Fault{why}; };
  const MethodInfo* info = find_integrator(id.scheme);
  if (info == nullptr) return input("atwood has no method `" + id.scheme + "`");
  if (id.rtol && !info->adaptive) return input(info->id + " takes equal steps; found a tolerance");
  for (const auto& [name, value] : id.overrides)
    if (const auto rule = info->rules.find(name); !id.rtol && rule != info->rules.end() && rule->second.needs_tolerance)
      return input(info->id + ": `" + name + "` has an effect only with a tolerance; expected one, as in " + info->id +
                   ":1e-12");
  const auto settings = merged_settings(*info, id.overrides);
  if (!settings) return settings.fault();
  if (!id.response.empty() && find_response(id.response) == nullptr && fluid::find_response(id.response) == nullptr)
    return input("atwood has no response `+" + id.response + "` to contacts or fluids");
  return combination_fault(id, *settings);
}

// Refuses a response that cannot follow the scene's contact laws, then runs.
Outcome run_in_contact(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                       int repeats) {
  const auto is_compliant = [](const PairLaw& law) { return law.contact_law != ContactLaw::rigid; };
  if (id.response.empty())
    return refused("atwood/" + id.scheme + " has no contact response; use +impulse, +event or +penalty");
  if (id.response != "penalty" && std::ranges::any_of(laws_in_play(scene), is_compliant))
    return refused("the scene has compliant contact laws: use +penalty");
  return run_with_contacts(id, scene, plan, observer, repeats);
}

// Which responses do not take mechanisms.
std::optional<Fault> joints_fault(const MethodId& id, const Scene& scene) {
  if (scene.joints.empty() && scene.ropes.empty()) return {};
  if (!scene.fluids.empty()) return Fault{"atwood does not support fluids in a scene with joints or ropes"};
  if (!contacts_possible(scene) || id.response != "event") return {};
  return Fault{"+event takes no bodies on joints or ropes; use +impulse or +penalty"};
}

// Of the scheme alone.
Outcome run_without_contacts(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                             int repeats) {
  if (id.scalar.empty() || id.scalar == "double") return run_smooth<double>(id, scene, plan, observer, repeats);
  if (id.scalar == "float") return run_smooth<float>(id, scene, plan, observer, repeats);
  if (id.scalar == "long-double") return run_smooth<long double>(id, scene, plan, observer, repeats);
  if (id.scalar == "quad") return run_smooth<Quad>(id, scene, plan, observer, repeats);
  return refused("atwood does not compute in `" + id.scalar + "`; use float, double, long-double or quad");
}

Outcome run(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const bool for_fluids = fluid::find_response(id.response) != nullptr;
  const MethodId own = for_fluids ? fluid::integrator_part(id) : integrator_part(id);
  if (const auto fault = method_fault(own)) return refused(*fault);
  if (for_fluids != !scene.fluids.empty())
    return refused(for_fluids ? "+" + id.response + " steps fluids, and the scene has none"
                              : "the scene has fluids: use +sph or +polynomial");
  if (const auto fault = joints_fault(id, scene)) return refused(*fault);
  if (for_fluids) return fluid::run_fluid(id, scene, plan, observer, repeats);
  if (contacts_possible(scene)) return run_in_contact(id, scene, plan, observer, repeats);
  Outcome outcome = run_without_contacts(own, scene, plan, observer, repeats);
  if (outcome.status == Status::unsupported && !id.response.empty())
    outcome.reason = "no contact is possible in this scene, so +" + id.response + " has no effect; " + outcome.reason;
  return outcome;
}

// Are there two shaped bodies, one of them moving, that no joint ties together?
bool untied_pair(const Scene& scene) {
  const auto shaped = [](const Body& body) { return !std::holds_alternative<std::monostate>(body.shape); };
  const int count = static_cast<int>(scene.bodies.size());
  for (int a = 0; a < count; ++a)
    for (int b = a + 1; b < count; ++b) {
      const Body &body_a = scene.bodies[a], &body_b = scene.bodies[b];
      if (shaped(body_a) && shaped(body_b) && !(body_a.fixed && body_b.fixed) && !joined(scene, a, b)) return true;
    }
  return false;
}

}  // namespace

Engine atwood_engine() {
  std::vector<MethodInfo> responses = contact_responses();
  responses.insert(responses.end(), fluid::responses().begin(), fluid::responses().end());
  Engine engine{"atwood", kVersion, "double", integrator_catalogue(), run, true, responses, find_scene_contacts};
  for (MethodInfo& scheme : engine.methods)
    if (const auto order = fluid::claimed_order(scheme)) scheme.claimed_order["fluid"] = *order;
  engine.fluids = true;
  engine.joints = true;
  return engine;
}

bool contacts_possible(const Scene& scene) {
  if (!scene.joints.empty()) return untied_pair(scene);
  int shaped = 0, moving = 0;
  for (const Body& body : scene.bodies) {
    if (std::holds_alternative<std::monostate>(body.shape)) continue;
    ++shaped;
    if (!body.fixed) ++moving;
  }
  return shaped >= 2 && moving >= 1;
}

Outcome run_with_contacts(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                          int repeats) {
  if (id.response == "impulse") return run_impulse(id, scene, plan, observer, repeats);
  if (id.response == "event") return run_event(id, scene, plan, observer, repeats);
  if (id.response == "penalty") return run_with_penalty(id, scene, plan, observer, repeats);
  return refused("atwood has no contact response `+" + id.response + "`; it has +impulse, +event and +penalty");
}

}  // namespace atwood
