// The description of a rival engine by its adapter, and the Engine made from it. Refusals, overrides, presets and the
// run are the same for all rivals.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::rivals {

struct Preset {
  std::string scheme, doc;
  Settings changes = {};  // of the rival's settings; one that is printed alone may change here too
  std::map<std::string, double> claimed_order = {};
  bool adaptive = false;  // accepts a tolerance, which is its setting "accuracy"; "steps" becomes "chosen"
  bool by_class =
      false;  // the tuned settings of the scene's class (tuned.hpp) are applied before the caller's overrides;
              // printed as "class_bounce" and so on
};

struct Rival {
  std::string name, version, scalar, source;
  std::vector<Setting> settings;  // all of them, with defaults, ranges and meanings; one is "substeps"
  std::vector<Preset> presets;
  bool compliant = false;  // has compliant contacts; `refusal` says which are not covered
  bool joints = false;     // takes joints; `refusal` says which are not covered
  // What is wrong with settings that are each in range. May be absent.
  std::function<std::optional<Fault>(const Settings&)> contradiction = {};
  // Why the engine cannot represent the scene with these settings, beyond the refusals of every adapter; none when it
  // can.
  std::function<std::optional<Fault>(const Scene&, const Settings&)> refusal;
  // Throws std::invalid_argument where the engine itself refuses the scene.
  std::function<std::unique_ptr<World>(const Scene&, const Settings&, bool observe)> make;
  // Messages of the engine since the last call; empty: none. May be absent.
  std::function<std::string()> diagnostics = {};
};

Engine engine_of(const Rival& rival);

}  // namespace atwood::rivals
