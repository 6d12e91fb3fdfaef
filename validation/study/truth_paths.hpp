// The motion of the truths in the store, for the pictures of a report.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood {

struct Cell;

// How many samples a scenario's truth is solved for: those that its runs share (metrics/instants.hpp).
std::int64_t samples_of_truth(const Scenario& scenario);
// The key of a scenario's truth in the store. `truth_build`: of the worker that solves it.
std::string truth_hash(const Scenario& scenario, const std::string& truth_build);

// How far a body is from the truth: x, y, z [m] and the rotation vector [rad], both in the axes of the world.
using PoseError = std::array<float, 6>;
struct MethodPath {
  std::string method;
  std::int64_t steps = 0;
  std::vector<std::vector<PoseError>> samples;  // sample by sample of each body, at the instants of the truth
};
// Sample by sample the pose of each body: x, y, z [m] and the quaternion w, x, y, z. Empty where the store has no
// truth.
using Pose = std::array<float, 7>;
struct TruthPath {
  std::string scenario;
  double t_end_s = 0;  // of the last sample
  std::vector<std::vector<Pose>> samples;
  std::vector<MethodPath> methods = {};  // that are drawn beside the truth
};
// One for each scenario of these cells whose truth is in the store; none of scenes with more than `most_bodies`. The
// scenes that most engines ran, `most_played` of them, have up to three methods, each of another engine and ours first:
// its default settings, or else rk4, with fixed steps at the rung nearest to 240 steps a second.
std::vector<TruthPath> load_truth_paths(const std::string& store_path, const std::vector<Cell>& cells,
                                        const std::string& truth_worker, std::size_t most_bodies,
                                        std::size_t most_played, const std::string& purpose = "run");

}  // namespace atwood
