#include "drawn_scenes.hpp"

#include <algorithm>
#include <variant>

#include "playback_parts.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMaxSamples = 121, kMaxTriangles = 2000;

bool drawable(const Scene& scene) {
  std::size_t triangles = 0;
  for (const Body& body : scene.bodies)
    if (const auto* mesh = std::get_if<Mesh>(&body.shape)) triangles += mesh->triangles.size();
  return triangles <= kMaxTriangles;
}

// Every n-th sample, and the last.
std::vector<std::size_t> kept_samples(std::size_t count) {
  const std::size_t every = (count + kMaxSamples - 1) / kMaxSamples;
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k + 1 < count; k += every) kept.push_back(k);
  kept.push_back(count - 1);
  return kept;
}

void append_part(JsonText& json, const char* name, const TruthPath& path, const std::vector<std::size_t>& kept,
                 std::size_t body, std::size_t first, std::size_t count, int digits) {
  json.key(name).begin_array();
  for (const std::size_t k : kept)
    for (std::size_t i = 0; i < count; ++i) json.number(static_cast<double>(path.samples[k][body][first + i]), digits);
  json.end_array();
}

void append_errors(JsonText& json, const char* name, const MethodPath& path, const std::vector<std::size_t>& kept,
                   std::size_t body, std::size_t first) {
  json.key(name).begin_array();
  for (const std::size_t k : kept)
    for (std::size_t i = first; i < first + 3 && k < path.samples.size(); ++i)
      json.number(static_cast<double>(path.samples[k][body][i]), 3);
  json.end_array();
}

// Methods beside the truth, as errors of its poses. One that ended early has fewer.
void append_methods(JsonText& json, const TruthPath& path, const std::vector<std::size_t>& kept) {
  json.key("methods").begin_array();
  for (const MethodPath& method : path.methods) {
    json.begin_object().member("id", method.method).member_integer("steps", method.steps).key("bodies").begin_array();
    for (std::size_t body = 0; body < method.samples.front().size(); ++body) {
      json.begin_object();
      append_errors(json, "p", method, kept, body, 0);
      append_errors(json, "r", method, kept, body, 3);
      json.end_object();
    }
    json.end_array().end_object();
  }
  json.end_array();
}

}  // namespace

void append_drawn_scenes(JsonText& json, const std::vector<Scenario>& scenarios, const std::vector<TruthPath>& paths) {
  json.begin_array();
  for (const TruthPath& path : paths) {
    const auto scenario =
        std::find_if(scenarios.begin(), scenarios.end(), [&](const Scenario& one) { return one.id == path.scenario; });
    if (scenario == scenarios.end() || !drawable(scenario->scene) || path.samples.empty()) continue;
    const std::vector<std::size_t> kept = kept_samples(path.samples.size());
    json.begin_object().member("id", path.scenario).key("t_end").number(path.t_end_s, 6).key("times").begin_array();
    for (const std::size_t k : kept)
      json.number(path.t_end_s * static_cast<double>(k) / static_cast<double>(path.samples.size() - 1), 6);
    json.end_array().key("scene");
    append_played_scene(json, scenario->scene);
    json.key("poses").begin_array();
    for (std::size_t body = 0; body < path.samples.front().size(); ++body) {
      const bool moves = std::any_of(path.samples.begin(), path.samples.end(), [&](const std::vector<Pose>& poses) {
        return poses[body] != path.samples.front()[body];
      });
      if (!moves) {
        json.null();
        continue;
      }
      json.begin_object();
      append_part(json, "p", path, kept, body, 0, 3, 5);
      append_part(json, "q", path, kept, body, 3, 4, 4);
      json.end_object();
    }
    json.end_array();
    if (!path.methods.empty()) append_methods(json, path, kept);
    json.end_object();
  }
  json.end_array();
}

}  // namespace atwood
