// Broad phases: which pairs of bounded bodies are worth the narrow phase. Planes stay outside: they meet everything.
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
  Aabb<S> box;        // already grown by whatever margin the caller wants
  Vec3<S> center;     // of the bounding sphere
  S radius{};         // ... likewise grown
  bool moves = true;  // two that do not move are no pair
};

// Every kind answers the same set: pairs whose boxes overlap and whose bounding spheres overlap (touching counts),
// sorted, each once. They differ in what it costs and in how many pairs they looked at closely (`kept`).
template <class S> class BroadPhase {
 public:
  virtual ~BroadPhase() = default;
  // Items may have moved and be as many as before or not; what is kept between calls is for speed alone.
  virtual void find(std::span<const BroadItem<S>> items, std::vector<BodyPair>& pairs) = 0;
  std::int64_t kept() const { return kept_; }  // pairs that its own test let through, before boxes and spheres decided

 protected:
  std::int64_t kept_ = 0;
};
// `team`: null is one thread. The pairs do not depend on it.
template <class S> std::unique_ptr<BroadPhase<S>> make_broad_phase(BroadPhaseKind kind, Team* team = nullptr);

}  // namespace atwood
