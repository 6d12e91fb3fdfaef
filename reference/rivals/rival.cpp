#include "rivals/rival.hpp"

#include <algorithm>
#include <stdexcept>

#include "rivals/scene_class.hpp"
#include "rivals/tuned.hpp"

namespace atwood::rivals {
namespace {

Outcome unsupported(const std::string& reason) {
  Outcome outcome;
  outcome.status = Status::unsupported;
  outcome.reason = reason;
  return outcome;
}

std::string schemes(const Rival& rival) {
  std::string text;
  for (const auto& preset : rival.presets) text += (text.empty() ? "" : ", ") + preset.scheme;
  return text;
}

Outcome run(const Rival& rival, const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
            int repeats) {
  const auto preset =
      std::find_if(rival.presets.begin(), rival.presets.end(), [&](const Preset& p) { return p.scheme == id.scheme; });
  if (id.engine != rival.name || preset == rival.presets.end()) {
    return unsupported(rival.name + " offers " + schemes(rival) + ", not " + id.engine + "/" + id.scheme);
  }
  MethodId plain = id;
  if (preset->adaptive) plain.rtol.reset(), plain.atol.reset();
  if (const auto reason = refusal(rival.name, plain, rival.scalar, scene, rival.compliant); !reason.empty())
    return unsupported(reason);
  try {
    Settings of_class = preset->settings;
    if (preset->by_class)
      of_class = with_overrides(of_class, tuned_changes(rival.name, scene_class(scene)), rival.fixed);
    Settings settings = with_overrides(of_class, id.overrides, rival.fixed);
    if (preset->adaptive && id.rtol) {
      settings["accuracy"] = *id.rtol;
      settings["steps"] = std::string("chosen");
    }
    const std::int64_t substeps = count(settings, "substeps", 1);
    rival.check(settings);
    if (const auto reason = rival.refusal(scene, settings); !reason.empty()) return unsupported(reason);
    const auto make = [&](const Scene& s, bool observe) { return rival.make(s, settings, observe); };
    if (rival.diagnostics) rival.diagnostics();
    Outcome outcome = run_world(make, scene, plan, observer, repeats, substeps);
    const std::string diagnostics = rival.diagnostics ? rival.diagnostics() : "";
    if (!diagnostics.empty()) outcome.reason += (outcome.reason.empty() ? "" : "; ") + diagnostics;
    return outcome;
  } catch (const std::invalid_argument& error) {
    return unsupported(rival.name + ": " + error.what());
  }
}

}  // namespace

Engine engine_of(const Rival& rival) {
  Engine engine;
  engine.name = rival.name;
  engine.version = rival.version;
  engine.scalar = rival.scalar;
  for (const auto& preset : rival.presets) {
    MethodInfo info;
    info.id = rival.name + "/" + preset.scheme;
    info.doc = preset.doc;
    info.source = rival.source;
    info.claimed_order = preset.claimed_order;
    info.adaptive = preset.adaptive;
    info.settings = preset.settings;
    for (const SceneClass each : all_scene_classes())
      if (preset.by_class) info.settings["class_" + to_string(each)] = tuned_words(rival.name, each);
    engine.methods.push_back(info);
  }
  engine.run = [rival](const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                       int repeats) { return run(rival, id, scene, plan, observer, repeats); };
  engine.frames = true;
  return engine;
}

}  // namespace atwood::rivals
