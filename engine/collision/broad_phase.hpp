// Broad phases: which pairs of bounded bodies may be in contact. Planes are not among the items: they are unbounded.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "collision/geometry.hpp"

namespace atwood {

class Team;

enum class BroadPhaseKind { all_pairs, manhattan, bounding_spheres, sweep_and_prune, grid, tree, bsp };
const std::vector<std::string>& broad_phase_names();       // "all-pairs", "manhattan", "bounding-spheres", ...
BroadPhaseKind broad_phase_kind(const std::string& name);  // throws std::invalid_argument with the names

using BodyPair = std::pair<std::int32_t, std::int32_t>;  // indices into `items`, first < second

template <class S> struct BroadItem {
  Aabb<S> box;        // [m], already enlarged by the caller's margin
  Vec3<S> center;     // of the bounding sphere
  S radius{};         // ... likewise enlarged
  bool moves = true;  // two items that do not move are not a pair
};

// Every kind returns the same set: pairs whose boxes and bounding spheres both overlap (touching counts), sorted, each
// once. The kinds differ in their cost and in how many candidate pairs they test (`tested`).
template <class S> class BroadPhase {
 public:
  virtual ~BroadPhase() = default;
  // Items may move and change in number between calls; data kept between calls affects speed only.
  virtual void find(std::span<const BroadItem<S>> items, std::vector<BodyPair>& pairs) = 0;
  std::int64_t tested() const {
    return tested_;
  }  // candidates of the last call: pairs whose boxes and spheres were tested

 protected:
  std::int64_t tested_ = 0;
};
// `team` null: one thread. The pairs do not depend on the number of threads.
template <class S> std::unique_ptr<BroadPhase<S>> make_broad_phase(BroadPhaseKind kind, Team* team = nullptr);

}  // namespace atwood
