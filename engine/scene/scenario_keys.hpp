// The keys of a scenario and of its scene in both forms: files (TOML) and resolved (JSON).
#pragma once

#include "scene/declarations.hpp"

namespace atwood {

// Parts of a file that are resolved after all keys are read, because names may refer to later declarations.
struct FileDraft {
  Scenario scenario;
  const Value *run = nullptr, *material = nullptr, *contact = nullptr, *body = nullptr, *grid = nullptr,
              *force = nullptr, *joint = nullptr, *rope = nullptr, *domain = nullptr, *fluid = nullptr,
              *fluid_boundary = nullptr, *probe = nullptr;
  std::optional<Real3> initial_state;
};

struct GridDraft {
  std::string body;
  std::vector<std::int64_t> counts;
  Real3 spacing_m{};
  double jitter_m = 0;
  std::int64_t seed = 0;
};

inline constexpr std::size_t kMaxBodies = 200'000;
// Tables of these names are compared with each other: [[fluid]]; [[grid]], [[rope]], [[fluid_boundary]], [[probe]].
inline constexpr std::size_t kMaxFluids = 64, kMaxTables = 1000;
inline constexpr std::size_t kMaxMaterials = 256;
inline constexpr std::int64_t kMaxSteps = 1'000'000'000'000;
inline constexpr std::size_t kMaxRungs = 64;
inline constexpr std::int64_t kMaxSamples = 1'000'000;
inline constexpr std::size_t kMaxFrames = 1'000'000;

const Keys<FileDraft>& file_keys();
const Keys<Scenario>& scenario_keys();  // the resolved form
const Keys<Scene>& scene_keys();        // the resolved form
const Keys<Scenario>& run_keys();
const Keys<GridDraft>& grid_keys();

Scene read_resolved_scene(Reading& r, const Value& v);
Value write_scene(const Scene& scene);

// Converts a draft into a scene: materials and pair laws, bodies and grids, forces. Throws InputError.
void resolve(Reading& r, const Value& document, FileDraft& draft);
// Checks of [run] that involve several keys. Throws InputError.
void check_run(Reading& r, const Value& run, const Scenario& scenario);

// Names of the bodies, for forces; a name used twice fails at its second use.
void add_body(Reading& r, SourceLocation location, Body body);
void require_few(Reading& r, const Value* tables, const std::string& where, std::size_t most);
void add_material(Reading& r, SourceLocation location, Material material);

}  // namespace atwood
