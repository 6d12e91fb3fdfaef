#include "ode/ode.hpp"

#include <stdexcept>

#include "ode/ode_world.hpp"
#include "rivals/world.hpp"

namespace atwood {
namespace {

Outcome unsupported(const std::string& reason) {
  Outcome outcome;
  outcome.status = Status::unsupported;
  outcome.reason = reason;
  return outcome;
}

Outcome run(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (id.engine != "ode" || (id.scheme != "default" && id.scheme != "tuned")) {
    return unsupported("ode offers default and tuned, not " + id.engine + "/" + id.scheme);
  }
  if (const auto reason = rivals::refusal("ode", id, "double", scene); !reason.empty()) return unsupported(reason);
  if (const auto reason = ode::refusal(scene); !reason.empty()) return unsupported(reason);
  try {
    const Settings preset = id.scheme == "tuned" ? ode::tuned_settings() : ode::default_settings();
    const Settings settings = rivals::with_overrides(preset, id.overrides, ode::fixed_settings());
    ode::check_settings(settings);
    const auto make = [&](const Scene& s, bool observe) { return ode::make_world(s, settings, observe); };
    ode::doubts_since_last_asked();
    Outcome outcome = rivals::run_world(make, scene, plan, observer, repeats, rivals::count(settings, "substeps", 1));
    const std::string doubts = ode::doubts_since_last_asked();
    if (!doubts.empty()) outcome.reason += (outcome.reason.empty() ? "" : "; ") + doubts;
    return outcome;
  } catch (const std::invalid_argument& error) {
    return unsupported(std::string("ode: ") + error.what());
  }
}

MethodInfo preset(const std::string& scheme, const std::string& doc, const Settings& settings) {
  MethodInfo info;
  info.id = "ode/" + scheme;
  info.doc = doc;
  info.source = "Smith, Open Dynamics Engine v0.5 user guide; ODE 0.16.2";
  info.settings = settings;
  return info;
}

}  // namespace

Engine ode_engine() {
  Engine engine;
  engine.name = "ode";
  engine.version = "0.16.2";
  engine.scalar = "double";
  engine.methods = {
      preset("default",
             "ODE as dWorldCreate makes it, stepped by dWorldStep: symplectic Euler, contacts by a linear complementarity "
             "problem. Friction is a coefficient and the pair's law is the scene's.",
             ode::default_settings()),
      preset("tuned",
             "ODE without penetration recovery (erp 0), with finite rotation and the friction pyramid turned along the "
             "slip.",
             ode::tuned_settings())};
  engine.run = run;
  engine.frames = true;
  return engine;
}

}  // namespace atwood
