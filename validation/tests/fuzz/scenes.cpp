// Scenes, and the files that scenes name.
#include "reports/command_line/mjcf_files.hpp"
#include "reports/command_line/trace_file.hpp"
#include "reports/command_line/urdf.hpp"
#include "scene/files.hpp"
#include "validation/tests/fuzz/target.hpp"

namespace atwood::fuzz {
namespace {

constexpr const char* kHead = "id = \"t\"\n[run]\nt_end_s = 1\nsteps = [4]\nsamples = 2\n";

// The resolved scenario as JSON reads back as itself.
void require_round_trip(const Scenario& scenario) {
  const std::string json = scenario_to_json(scenario);
  require(scenario_to_json(scenario_from_json(json)) == json, "a scenario read from its JSON is the same");
}

void read_scene_with(std::string_view toml) {
  const auto scenario = read_or_refuse<InputError>([&] { return read_scenario_text(toml, "scene.toml", folder()); });
  if (scenario) require_round_trip(*scenario);
}

}  // namespace

void read_toml_scene(std::string_view bytes) { read_scene_with(bytes); }

void read_json_scene(std::string_view bytes) {
  const auto scenario = read_or_refuse<InputError>([&] { return scenario_from_json(bytes); });
  if (scenario) require_round_trip(*scenario);
  const auto scene = read_or_refuse<InputError>([&] { return scene_from_json(bytes); });
  if (!scene) return;
  const std::string json = scene_to_json(*scene);
  require(scene_to_json(scene_from_json(json)) == json, "a scene read from its JSON is the same");
}

void read_points_file(std::string_view bytes) {
  file("points.csv", bytes);
  read_scene_with(
      std::string(kHead) +
      "[domain]\ndimensions = 2\n[[fluid]]\nname = \"water\"\nregion.file = \"points.csv\"\narrangement = \"file\"\n"
      "spacing_m = 0.1\nsound_speed_m_per_s = 10\ndensity_kg_per_m3 = 1000\n");
}

void read_obj_file(std::string_view bytes) {
  file("mesh.obj", bytes);
  const std::string shape = "shape.mesh.file = \"mesh.obj\"\n";
  read_scene_with(kHead + ("[[body]]\nname = \"b\"\nmass_kg = 1\n" + shape));  // closed, its centroid at 0
  read_scene_with(kHead + ("[[body]]\nname = \"b\"\nfixed = true\n" + shape));
}

void read_values_file(std::string_view bytes) {
  file("values.csv", bytes);
  read_scene_with(std::string(kHead) +
                  "[[body]]\nname = \"b\"\nmass_kg = 1\n"
                  "[truth]\nkind = \"values\"\nfile = \"values.csv\"\n");
}

// The importer itself reads what it wrote.
void read_urdf(std::string_view bytes) {
  const auto scene = read_or_refuse<InputError>([&] { return import_urdf(bytes, "robot.urdf"); });
  if (scene) read_scenario_text(scene->toml, "robot.toml", folder());
}

void read_mjcf(std::string_view bytes) {
  read_or_refuse<InputError>([&] {
    require_files_in_folder(bytes, folder() + "/model.xml");
    return 0;
  });
}

void read_trace_csv(std::string_view bytes) {
  static const Scene scene =
      read_scenario_text(std::string(kHead) +
                             "[[body]]\nname = \"a\"\nmass_kg = 1\n[[body]]\nname = \"b\"\nmass_kg = 1\n"
                             "[[body]]\nname = \"c\"\nfixed = true\n",
                         "scene.toml", folder())
          .scene;
  const auto trace = read_or_refuse<InputError>([&] { return read_trace(std::string(bytes), "trace.csv", scene); });
  if (!trace) return;
  for (const SampleView sample : trace->run.values)
    require(sample.bodies.size() == scene.bodies.size(), "an instant of a trace has every body");
}

}  // namespace atwood::fuzz
