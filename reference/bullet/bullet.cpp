#include "bullet/bullet.hpp"

#include <LinearMath/btScalar.h>

#include <stdexcept>

#include "bullet/bullet_world.hpp"
#include "rivals/world.hpp"

namespace atwood {
namespace {

constexpr bool kDouble = sizeof(btScalar) == 8;
const char* const kName = kDouble ? "bullet64" : "bullet32";
const char* const kScalar = kDouble ? "double" : "float";

Outcome unsupported(const std::string& reason) {
  Outcome outcome;
  outcome.status = Status::unsupported;
  outcome.reason = reason;
  return outcome;
}

Outcome run(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (id.engine != kName || (id.scheme != "default" && id.scheme != "tuned")) {
    return unsupported(std::string(kName) + " offers default and tuned, not " + id.engine + "/" + id.scheme);
  }
  if (const auto reason = rivals::refusal(kName, id, kScalar, scene); !reason.empty()) return unsupported(reason);
  try {
    const Settings preset = id.scheme == "tuned" ? bullet::tuned_settings() : bullet::default_settings();
    const Settings settings = rivals::with_overrides(preset, id.overrides, bullet::fixed_settings());
    bullet::check_settings(settings);
    const auto make = [&](const Scene& s, bool observe) { return bullet::make_world(s, settings, observe); };
    return rivals::run_world(make, scene, plan, observer, repeats, rivals::count(settings, "substeps", 1));
  } catch (const std::invalid_argument& error) {
    return unsupported(std::string(kName) + ": " + error.what());
  }
}

MethodInfo preset(const std::string& scheme, const std::string& doc, const Settings& settings) {
  MethodInfo info;
  info.id = std::string(kName) + "/" + scheme;
  info.doc = doc;
  info.source = "Coumans, Bullet 3.24 Physics SDK manual; btDiscreteDynamicsWorld";
  info.settings = settings;
  return info;
}

}  // namespace

Engine bullet_engine() {
  Engine engine;
  engine.name = kName;
  engine.version = std::to_string(BT_BULLET_VERSION / 100) + "." + std::to_string(BT_BULLET_VERSION % 100);
  engine.scalar = kScalar;
  engine.methods = {
      preset("default",
             "Bullet's rigid bodies as a program gets them that sets nothing: symplectic Euler, implicit gyroscopic "
             "term, sequential impulses with speculative contacts. Only sleeping is off and the pair's law is the "
             "scene's.",
             bullet::default_settings()),
      preset("tuned",
             "Bullet with speculative contacts, the restitution threshold and velocity-level penetration recovery off, "
             "and 50 solver iterations: the most accurate bounce its own settings reach.",
             bullet::tuned_settings())};
  engine.run = run;
  engine.frames = true;
  return engine;
}

}  // namespace atwood
