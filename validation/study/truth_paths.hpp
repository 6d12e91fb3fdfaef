// The motion of the truths in the store, for the pictures of a report.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood {

struct Cell;

// The key of a scenario's truth in the store. `truth_build`: of the worker that solves it.
std::string truth_hash(const Scenario& scenario, const std::string& truth_build);

// Sample by sample the pose of each body: x, y, z [m] and the quaternion w, x, y, z. Empty where the store has no truth.
using Pose = std::array<float, 7>;
struct TruthPath {
  std::string scenario;
  double t_end_s = 0;  // of the last sample
  std::vector<std::vector<Pose>> samples;
};
// One for each scenario of these cells whose truth is in the store; none of scenes with more than `most_bodies`.
std::vector<TruthPath> load_truth_paths(const std::string& store_path, const std::vector<Cell>& cells,
                                        const std::string& truth_worker, std::size_t most_bodies);

}  // namespace atwood
