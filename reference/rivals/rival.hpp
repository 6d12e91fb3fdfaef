// A rival as its adapter describes it, and the Engine that comes of it: refusals, overrides, presets and the run are
// the same for all of them.
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::rivals {

struct Preset {
  std::string scheme, doc;
  Settings settings;  // all of them, as printed
  std::map<std::string, double> claimed_order = {};
  bool adaptive = false;  // takes a tolerance: its settings have "accuracy", and "steps" becomes "chosen"
  bool by_class = false;  // settings are changed by what tuned.hpp holds for the scene's class, before a caller's own
                          // changes; printed as "class_bounce" and so on
};

struct Rival {
  std::string name, version, scalar, source;
  std::vector<Preset> presets;
  std::set<std::string> fixed;  // settings that are printed and can't be changed
  bool gives_way = false;       // may hold contacts of a given stiffness: `refusal` says which
  // Throws std::invalid_argument on a value out of range.
  std::function<void(const Settings&)> check;
  // What the engine can't hold beyond what every adapter refuses; empty when it can.
  std::function<std::string(const Scene&, const Settings&)> refusal;
  // Throws std::invalid_argument where the engine itself refuses the scene.
  std::function<std::unique_ptr<World>(const Scene&, const Settings&, bool observe)> make;
  // What the engine complained of since it was last asked; empty: nothing. May be absent.
  std::function<std::string()> doubts = {};
};

// Its settings have "substeps".
Engine engine_of(const Rival& rival);

}  // namespace atwood::rivals
