#include "scene/files.hpp"

#include <filesystem>

#include "scene/input_file.hpp"
#include "scene/scenario_keys.hpp"

namespace atwood {
Scenario read_scenario_text(std::string_view toml, const std::string& name, const std::string& folder) {
  const Value document = parse_toml(toml, name);
  Reading r;
  r.name = name;
  r.folder = folder;
  r.where = "the scenario";
  FileDraft draft;
  read_table(r, document, file_keys(), {}, draft);
  resolve(r, document, draft);
  draft.scenario.notes = std::move(r.notes);
  return std::move(draft.scenario);
}

Scenario read_scenario(const std::string& path) {
  const std::string text = read_input_file(path, "a scenario file (TOML)", largest::kScenario);
  Scenario scenario = read_scenario_text(text, path, std::filesystem::path(path).parent_path().string());
  scenario.path = path;
  return scenario;
}

std::string scenario_to_json(const Scenario& scenario) {
  Value table{Value::Table{}};
  write_table(scenario.scene, scenario, scenario_keys(), table);
  return to_json_text(table, false);
}

Scenario scenario_from_json(std::string_view json) {
  Reading r;
  r.name = "scenario (JSON)";
  r.form = Form::resolved;
  r.where = "the scenario";
  const Value document = parse_json(json, r.name);
  Scenario scenario;
  read_table(r, document, scenario_keys(), {}, scenario);
  return scenario;
}

std::string scene_to_json(const Scene& scene) { return to_json_text(write_scene(scene), false); }

Scene scene_from_json(std::string_view json) {
  Reading r;
  r.name = "scene (JSON)";
  r.form = Form::resolved;
  r.where = "the scene";
  return read_resolved_scene(r, parse_json(json, r.name));
}

std::string scenario_schema() {
  Value schema = table_of({{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                           {"$id", "https://atwood.invalid/scenario.schema.json"},
                           {"title", "Atwood scenario"},
                           {"description",
                            "A scenario file (TOML). $defs.resolved_scenario and $defs.resolved_scene "
                            "describe the JSON that workers read."}});
  Value body = object_schema(file_keys(), Form::file);
  for (Member& member : std::get<Value::Table>(body.data)) add(schema, member.key, std::move(member.value));
  add(schema, "$defs",
      table_of({{"shape", shape_schema(Form::file)},
                {"resolved_shape", shape_schema(Form::resolved)},
                {"force", force_schema(Form::file)},
                {"resolved_scenario", object_schema(scenario_keys(), Form::resolved)},
                {"resolved_scene", object_schema(scene_keys(), Form::resolved)}}));
  return to_json_text(schema, true);
}

}  // namespace atwood
