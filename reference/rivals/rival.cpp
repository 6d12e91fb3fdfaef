#include "rivals/rival.hpp"

#include <algorithm>
#include <stdexcept>

#include "protocol/printed_setting.hpp"
#include "protocol/refusal.hpp"
#include "rivals/scene_class.hpp"
#include "rivals/tuned.hpp"

namespace atwood::rivals {
namespace {

std::string schemes(const Rival& rival) {
  std::string text;
  for (const auto& preset : rival.presets) text += (text.empty() ? "" : ", ") + preset.scheme;
  return text;
}

MethodInfo described(const Rival& rival, const Preset& preset) {
  MethodInfo info;
  info.id = rival.name + "/" + preset.scheme;
  info.doc = preset.doc;
  info.source = rival.source;
  info.claimed_order = preset.claimed_order;
  info.adaptive = preset.adaptive;
  declare_settings(info, rival.settings);
  for (const auto& [name, value] : preset.changes) {
    if (is_printed(info.rules.at(name))) declare_settings(info, {printed(name, value, info.rules.at(name).doc)});
    info.settings.at(name) = value;
  }
  for (const SceneClass each : all_scene_classes())
    if (preset.by_class)
      declare_settings(info, {printed("class_" + to_string(each), tuned_words(rival.name, each),
                                      "Changes of the defaults in scenes of this class.")});
  return info;
}

// The preset's settings, changed by the class of the scene, then by the id.
Result<Settings> settings_of(const Rival& rival, const Preset& preset, const MethodId& id, const Scene& scene) {
  MethodInfo info = described(rival, preset);
  if (preset.by_class) {
    const Result<Settings> of_class = merged_settings(info, tuned_changes(rival.name, scene_class(scene)));
    if (!of_class) return of_class.fault();
    info.settings = *of_class;
  }
  Settings overrides = id.overrides;
  if (preset.adaptive && id.rtol) overrides["accuracy"] = *id.rtol;
  Result<Settings> settings = merged_settings(info, overrides);
  if (!settings) return settings;
  if (preset.adaptive && id.rtol) settings->at("steps") = std::string("chosen");
  if (rival.contradiction)
    if (const auto fault = rival.contradiction(*settings)) return Fault{info.id + ": " + fault->reason};
  return settings;
}

Outcome run(const Rival& rival, const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
            int repeats) {
  const auto preset =
      std::find_if(rival.presets.begin(), rival.presets.end(), [&](const Preset& p) { return p.scheme == id.scheme; });
  if (id.engine != rival.name || preset == rival.presets.end()) {
    return refused(rival.name + " offers " + schemes(rival) + ", not " + id.engine + "/" + id.scheme);
  }
  MethodId plain = id;
  if (preset->adaptive) plain.rtol.reset(), plain.atol.reset();
  if (const auto fault = refusal(rival.name, plain, rival.scalar, scene, rival.compliant)) return refused(*fault);
  if (!rival.joints && has_mechanism(scene)) return refused(rival.name + "'s adapter takes no joints or ropes");
  const Result<Settings> settings = settings_of(rival, *preset, id, scene);
  if (!settings) return refused(settings.fault());
  try {
    if (const auto fault = rival.refusal(scene, *settings)) return refused(*fault);
    const auto make = [&](const Scene& s, bool observe) { return rival.make(s, *settings, observe); };
    if (rival.diagnostics) rival.diagnostics();
    Outcome outcome = run_world(make, scene, plan, observer, repeats, count(*settings, "substeps"));
    const std::string diagnostics = rival.diagnostics ? rival.diagnostics() : "";
    for (const std::string& more : {diagnostics, convention_note(rival.name, scene)})
      if (!more.empty()) outcome.reason += (outcome.reason.empty() ? "" : "; ") + more;
    return outcome;
  } catch (const std::invalid_argument& error) {
    return refused(rival.name + ": " + error.what());
  }
}

}  // namespace

Engine engine_of(const Rival& rival) {
  Engine engine;
  engine.name = rival.name;
  engine.version = rival.version;
  engine.scalar = rival.scalar;
  for (const auto& preset : rival.presets) engine.methods.push_back(described(rival, preset));
  engine.run = [rival](const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                       int repeats) { return run(rival, id, scene, plan, observer, repeats); };
  engine.frames = true;
  engine.joints = rival.joints;
  return engine;
}

}  // namespace atwood::rivals
