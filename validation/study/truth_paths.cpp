#include "validation/study/truth_paths.hpp"

#include <cmath>
#include <set>

#include "protocol/wire.hpp"
#include "scene/files.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/machine.hpp"
#include "validation/study/store.hpp"
#include "validation/study/study.hpp"

namespace atwood {
namespace {

Pose pose_of(const BodySample& body) {
  Pose pose{};
  for (std::size_t i = 0; i < 3; ++i) pose[i] = static_cast<float>(body.p_m[i]);
  for (std::size_t i = 0; i < 4; ++i) pose[3 + i] = static_cast<float>(body.q_wxyz[i]);
  return pose;
}

bool finite(const std::vector<Pose>& poses) {
  for (const Pose& pose : poses)
    for (const float x : pose)
      if (!std::isfinite(x)) return false;
  return true;
}

TruthPath path_of(const Scenario& scenario, const Truth& truth) {
  TruthPath path;
  path.scenario = scenario.id;
  for (const Sample& sample : truth.values) {
    std::vector<Pose> poses;
    for (const BodySample& body : sample.bodies) poses.push_back(pose_of(body));
    if (!finite(poses)) break;
    path.samples.push_back(std::move(poses));
  }
  if (!path.samples.empty())
    path.t_end_s =
        scenario.t_end_s * static_cast<double>(path.samples.size() - 1) / static_cast<double>(scenario.samples);
  return path;
}

}  // namespace

std::string truth_hash(const Scenario& scenario, const std::string& truth_build) {
  const std::string values = scenario.truth.file.empty() ? "" : file_hash(scenario.truth.file);
  return content_hash({"truth 2", scene_to_json(scenario.scene), format_double(scenario.t_end_s),
                       std::to_string(scenario.samples), std::to_string(static_cast<int>(scenario.truth.kind)),
                       scenario.truth.solution, values, truth_build, machine_arithmetic(),
                       std::to_string(wire::kProtocol)});
}

std::vector<TruthPath> load_truth_paths(const std::string& store_path, const std::vector<Cell>& cells,
                                        const std::string& truth_worker, std::size_t most_bodies) {
  std::vector<TruthPath> paths;
  if (!store_exists(store_path)) return paths;
  Store store(store_path, Store::Mode::read);
  if (store.empty()) return paths;
  const std::string build = find_workers({truth_worker}).front().build_id;
  std::set<std::string> seen;
  for (const Cell& cell : cells) {
    const Scenario& scenario = *cell.scenario;
    if (scenario.truth.kind == TruthKind::none || !scenario.scene.fluids.empty() || !scenario.frame_ends_s.empty() ||
        scenario.samples <= 0 || scenario.scene.bodies.size() > most_bodies || !seen.insert(scenario.id).second)
      continue;
    const std::optional<Truth> truth = store.truth(truth_hash(scenario, build));
    if (!truth || truth->values.size() < 2) continue;
    TruthPath path = path_of(scenario, *truth);
    if (path.samples.size() > 1) paths.push_back(std::move(path));
  }
  return paths;
}

}  // namespace atwood
