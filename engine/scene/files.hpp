// Scenarios in and out: TOML files people write, JSON that workers read, the JSON Schema of both.
// All three come from the same declarations (one table of keys per kind of object).
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "scene/scene.hpp"

namespace atwood {

// What a user got wrong, where, what was found, what was expected. The message reads
//   scenes/rod.toml:12:8: unknown key `mas_kg` in [[body]]; expected one of mass_kg, ... (did you mean mass_kg?)
// The command line exits with 2 on it.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Reads, checks and resolves a scenario file. Throws InputError.
Scenario read_scenario(const std::string& path);
// The same from text; `name` stands for the file in messages, `folder` is where `file` keys are looked up.
Scenario read_scenario_text(std::string_view toml, const std::string& name, const std::string& folder);

// The resolved scenario as one line of JSON (deterministic key order, shortest round-trip doubles), and back.
// Bodies and materials go by name in JSON. scene_from_json(scene_to_json(s)) == s, to the bit.
std::string scenario_to_json(const Scenario& scenario);
Scenario scenario_from_json(std::string_view json);
std::string scene_to_json(const Scene& scene);
Scene scene_from_json(std::string_view json);

// JSON Schema (draft 2020-12) of a scenario file, pretty-printed.
std::string scenario_schema();

}  // namespace atwood
