#include "validation/study/truth_paths.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "protocol/wire.hpp"
#include "scene/files.hpp"
#include "validation/metrics/instants.hpp"
#include "validation/study/campaigns.hpp"
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
  for (const SampleView sample : truth.values) {
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

// The rotation vector of q q_truth^-1, the shorter of the two.
PoseError error_of(const BodySample& body, const BodySample& truth) {
  PoseError error{};
  for (std::size_t i = 0; i < 3; ++i) error[i] = static_cast<float>(body.p_m[i] - truth.p_m[i]);
  const auto& [a, b, c, d] = body.q_wxyz;
  const auto& [w, x, y, z] = truth.q_wxyz;
  const auto narrow = [](Wide value) { return static_cast<double>(value); };
  const double cosine = narrow(a * w + b * x + c * y + d * z);
  const std::array<double, 3> v{narrow(b * w - a * x - c * z + d * y), narrow(c * w - a * y - d * x + b * z),
                                narrow(d * w - a * z - b * y + c * x)};
  const double sine = std::hypot(v[0], v[1], v[2]), sign = cosine < 0 ? -1 : 1;
  const double scale = sine > 0 ? 2 * sign * std::atan2(sine, sign * cosine) / sine : 0;
  for (std::size_t i = 0; i < 3; ++i) error[3 + i] = static_cast<float>(scale * v[i]);
  return error;
}

MethodPath method_path(const Cell& cell, const Truth& truth, const SampleSeries& values) {
  MethodPath path{cell.method, cell.plan.steps, {}};
  for (std::size_t k = 0; k < std::min(values.size(), truth.values.size()); ++k) {
    const auto &bodies = values[k].bodies, &exact = truth.values[k].bodies;
    std::vector<PoseError> errors;
    for (std::size_t i = 0; i < std::min(bodies.size(), exact.size()); ++i) {
      errors.push_back(error_of(bodies[i], exact[i]));
      for (const float x : errors.back())
        if (!std::isfinite(x)) return path;
    }
    path.samples.push_back(std::move(errors));
  }
  return path;
}

// Of an engine in two precisions, bullet32 and bullet64, one name.
std::string engine_name(const std::string& method) {
  const std::string name = method.substr(0, method.find('/'));
  return name.ends_with("32") || name.ends_with("64") ? name.substr(0, name.size() - 2) : name;
}

// Which method stands for its engine: in double, the default settings, or else classical Runge-Kutta.
std::pair<bool, int> rank_of(const Cell& cell) {
  const std::string name = cell.method.substr(cell.method.find('/') + 1);
  const int usual = name == "default" ? 0 : name == "rk4" || name.starts_with("rk4+") ? 1 : 2;
  return {cell.method.substr(0, cell.method.find('/')).ends_with("32"), usual};
}

// Of each engine one cell of the scenario, ours first.
std::vector<const Cell*> played_cells(const std::vector<Cell>& cells, const std::string& scenario) {
  constexpr double steps_per_s = 240;  // steps a second
  constexpr std::size_t max_methods = 3;
  const auto away = [](const Cell& cell) {
    return std::abs(std::log(static_cast<double>(cell.plan.steps) / (steps_per_s * cell.plan.t_end_s)));
  };
  std::vector<const Cell*> chosen;
  for (const Cell& cell : cells) {
    if (cell.scenario->id != scenario || cell.worker < 0 || cell.probe != Probe::none ||
        cell.method.find_first_of(":@{") != std::string::npos)
      continue;
    const auto same = std::find_if(chosen.begin(), chosen.end(), [&](const Cell* one) {
      return engine_name(one->method) == engine_name(cell.method);
    });
    if (same == chosen.end()) {
      chosen.push_back(&cell);
      continue;
    }
    if (rank_of(cell) < rank_of(**same) || (cell.method == (*same)->method && away(cell) < away(**same))) *same = &cell;
  }
  std::stable_partition(chosen.begin(), chosen.end(),
                        [](const Cell* cell) { return engine_name(cell->method) == "atwood"; });
  if (chosen.size() > max_methods) chosen.resize(max_methods);
  return chosen;
}

// The scenarios that most engines ran, of those that have a path.
std::vector<TruthPath*> played_paths(std::vector<TruthPath>& paths, const std::vector<Cell>& cells, std::size_t most) {
  std::map<std::string, std::set<std::string>> engines;
  for (const Cell& cell : cells)
    if (cell.worker >= 0) engines[cell.scenario->id].insert(engine_name(cell.method));
  std::vector<TruthPath*> order;
  for (TruthPath& path : paths) order.push_back(&path);
  std::stable_sort(order.begin(), order.end(), [&](const TruthPath* a, const TruthPath* b) {
    return engines[a->scenario].size() > engines[b->scenario].size();
  });
  if (order.size() > most) order.resize(most);
  return order;
}

}  // namespace

std::int64_t samples_of_truth(const Scenario& scenario) {
  const TruthKind kind = scenario.truth.kind;
  const bool solved = kind == TruthKind::closed_form || kind == TruthKind::extended || kind == TruthKind::cvode;
  return solved ? shared_samples(scenario) : scenario.samples;
}

std::string truth_hash(const Scenario& scenario, const std::string& truth_build) {
  const std::string values = scenario.truth.file.empty() ? "" : file_hash(scenario.truth.file);
  return content_hash({"truth 2", scene_to_json(scenario.scene), format_double(scenario.t_end_s),
                       std::to_string(samples_of_truth(scenario)),
                       std::to_string(static_cast<int>(scenario.truth.kind)), scenario.truth.solution, values,
                       truth_build, machine_arithmetic(), std::to_string(wire::kProtocol)});
}

std::vector<TruthPath> load_truth_paths(const std::string& store_path, const std::vector<Cell>& cells,
                                        const std::string& truth_worker, std::size_t most_bodies,
                                        std::size_t most_played, const std::string& purpose) {
  std::vector<TruthPath> paths;
  if (!store_exists(store_path)) return paths;
  Store store(store_path, Store::Mode::read);
  if (store.empty()) return paths;
  const std::string build = find_workers({truth_worker}).front().build_id;
  std::map<std::string, Truth> truths;
  for (const Cell& cell : cells) {
    const Scenario& scenario = *cell.scenario;
    if (scenario.truth.kind == TruthKind::none || !scenario.scene.fluids.empty() || !scenario.frame_ends_s.empty() ||
        scenario.samples <= 0 || scenario.scene.bodies.size() > most_bodies || truths.contains(scenario.id))
      continue;
    std::optional<Truth> truth = store.truth(truth_hash(scenario, build));
    if (std::optional<Truth> fewer; truth) {
      at_samples(*truth, static_cast<std::size_t>(scenario.samples), fewer);
      if (fewer) truth = std::move(fewer);
    }
    if (truth && truth->values.size() > 1) {
      TruthPath path = path_of(scenario, *truth);
      if (path.samples.size() > 1) paths.push_back(std::move(path));
    }
    if (truth) truth->bars.clear();
    truths[scenario.id] = truth ? std::move(*truth) : Truth{};
  }
  const Campaigns campaigns = Campaigns::latest(store, cells, purpose);
  for (TruthPath* path : played_paths(paths, cells, most_played))
    for (const Cell* cell : played_cells(cells, path->scenario)) {
      const std::string hash = campaigns.keys(*cell).accuracy;
      const std::optional<RunRecord> run = store.run(hash);
      if (!run || run->outcome.status != Status::ok) continue;
      MethodPath method = method_path(*cell, truths[path->scenario], store.recording(hash, run->outcome).values);
      if (method.samples.size() > 1) path->methods.push_back(std::move(method));
    }
  return paths;
}

}  // namespace atwood
