// A method is a value: what it is called, what it claims, how it is set, and how it runs.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocol/contact_query.hpp"
#include "protocol/sample.hpp"
#include "protocol/setting.hpp"
#include "scene/scene.hpp"

namespace atwood {

// <engine>/<scheme>[:rtol[,atol]][+<response>][@<scalar>][{setting=value,...}]
struct MethodId {
  std::string engine, scheme;
  std::optional<double> rtol, atol;  // atol = rtol / 100 unless given
  std::string response;              // "", "impulse", "event", "penalty"
  std::string scalar;                // "" (the engine's own, double), "float", "double", "long-double", "quad"
  Settings overrides;
};
MethodId parse_method_id(const std::string& text);  // throws std::invalid_argument with what was expected
std::string to_string(const MethodId& id);          // canonical: parse(to_string(id)) == id

struct MethodInfo {
  std::string id;           // base id, without tolerance or suffixes: "atwood/rk4", "bullet64/default"
  std::string doc, source;  // one paragraph; the paper or manual it follows
  std::map<std::string, double> claimed_order;  // class of motion -> order: "point-mass", "velocity-dependent",
                                                // "rotation", "mechanism", "loop", "contact", "fluid"; absent: none
  bool adaptive = false;                        // takes a tolerance
  Settings settings;                            // every setting of the engine behind the method, at its default
  SettingRules rules = {};  // what the settings mean and take; an engine may leave some out, then it judges them itself
  std::string formula = {};  // what a step computes, in plain text, one equation a line
};
// Settings of a method from their table: defaults and rules; replaces those of the same names.
void declare_settings(MethodInfo& info, const std::vector<Setting>& table);
// The method's settings with `overrides` over them. Fails for an unknown name, a value of another type
// or one outside its range.
Result<Settings> merged_settings(const MethodInfo& info, const Settings& overrides);

// What one engine is. `run` never throws on what a scene may contain: it answers unsupported with a reason that names
// the engine and the thing. `repeats` > 0 asks for the timed pass: no observation, that many entries in busy_ns.
struct Engine {
  std::string name, version, scalar;  // "bullet64", "3.24", "double"
  std::vector<MethodInfo> methods;
  std::function<Outcome(const MethodId&, const Scene&, const Plan&, const Observer&, int repeats)> run;
  bool frames = false;  // takes steps of recorded, unequal length (Plan::frame_ends_s)
  std::vector<MethodInfo> responses =
      {};  // "+impulse", ...: what may follow a scheme, with doc and settings of its own
  // Where the scene's bodies touch; never throws. Empty: the engine has no such query.
  std::function<ContactAnswer(const Scene&, const ContactQuery&)> contacts = {};
  // What a worker says in hello of the code behind it, both optional. `fingerprint`: any text that changes whenever its
  // results may change (a build id, a commit). `files`: files whose bytes decide its results.
  std::string fingerprint = {};
  std::vector<std::string> files = {};
  bool fluids = false;  // simulates scenes with fluids: its samples have their particles
  bool joints = false;  // simulates scenes with joints or ropes: its samples have their coordinates
};

}  // namespace atwood
