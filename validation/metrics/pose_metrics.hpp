// Sweeps of seeded poses of two bodies: an engine's answers compared with the truth's.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "protocol/pair_query.hpp"
#include "scene/scene.hpp"
#include "validation/row.hpp"

namespace atwood {

// A pose that shows what an engine did worst: "miss", "false-hit", "depth", "normal", "distance", "time".
struct WorstPose {
  std::string what;
  std::int64_t index = 0;
  double error = 0;
};

struct PoseRows {
  std::vector<Row> rows;         // body: the pair
  std::vector<WorstPose> worst;  // at most one per kind; for misses the deepest overlap, for false hits the largest gap
};

using SceneOfPose = std::function<Scene(std::int64_t index)>;

// Answers to poses 0..n of a pair. A hit or miss counts only where the true gap exceeds the round-off of
// the bodies' positions (64 units in the last place of the largest coordinate) and the truth's bar. Errors of depth and
// distance are relative to pair_size_m; the normal's [rad] counts where the next direction's depth is 1e-3 of the depth
// (and 1e-9 of the size) behind; depth, normal and distance where engine and truth agree on overlap.
//
// An engine that computes in float is given each coordinate, size and attitude rounded to float, and answers that pose:
// the bar of its figures is the change by this rounding, and misses and false hits count only above it. `at_unit_size`:
// the pose was scaled to unit size about the first body's position (rivals/unit_size.hpp), where only distances are
// rounded.
struct InputRounding {
  double unit = 0;  // 2^-24 of an engine in float; 0: double, whose round-off is allowed for above
  bool at_unit_size = false;
};
InputRounding input_rounding(const std::string& scalar, const std::string& test);
PoseRows measure_poses(const std::string& pair, bool swept, const SceneOfPose& scene_of,
                       std::span<const PoseAnswer> answers, std::span<const PoseAnswer> truths,
                       const InputRounding& rounding = {});

// Figures of the whole sweep, without a body, from one method's rows of pairs: sums of misses and false hits, and the
// largest errors of all pairs.
std::vector<Row> over_all_pairs(std::span<const Row> rows);

}  // namespace atwood
