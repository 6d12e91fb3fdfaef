// What the broad phases share: the overlap test of a pair, the sort of the pairs, and a factory for each kind.
#pragma once

#include <algorithm>
#include <limits>

#include "collision/broad_phase.hpp"
#include "parallel/team.hpp"

namespace atwood::broad {

template <class S> using Items = std::span<const BroadItem<S>>;

// Boxes that touch overlap; boxes with NaN overlap nothing.
template <class S> inline bool boxes_overlap(const Aabb<S>& a, const Aabb<S>& b) {
  return (a.low.x <= b.high.x) & (b.low.x <= a.high.x) & (a.low.y <= b.high.y) & (b.low.y <= a.high.y) &
         (a.low.z <= b.high.z) & (b.low.z <= a.high.z);
}
template <class S> inline bool spheres_overlap(const BroadItem<S>& a, const BroadItem<S>& b) {
  const Vec3<S> d = b.center - a.center;
  const S radii = a.radius + b.radius;
  return dot(d, d) <= radii * radii;
}
template <class S> inline bool is_pair(const BroadItem<S>& a, const BroadItem<S>& b) {
  return (a.moves | b.moves) & boxes_overlap(a.box, b.box) & spheres_overlap(a, b);
}

// The pair with its smaller index first.
inline BodyPair ordered(std::int32_t a, std::int32_t b) { return a < b ? BodyPair(a, b) : BodyPair(b, a); }

// A key for sorting: NaN becomes infinity and comes last, so that the order is a strict weak one.
template <class S> inline S sortable(S x) { return x == x ? x : std::numeric_limits<S>::infinity(); }

// Sorts pairs of the indices 0 .. count - 1 into the order of BodyPair: counting sort by the first index, then each
// index's few partners.
class PairSort {
 public:
  void sort(const std::vector<BodyPair>& found, std::size_t count, std::vector<BodyPair>& pairs);

 private:
  std::vector<std::int32_t> start_;
};

// ---- the kinds ----------------------------------------------------------------------------------------------------
// Pairs whose centres are at most `radii` (r_a + r_b) apart in the Manhattan distance. No overlapping pair is lost at
// sqrt(3), the largest ratio of that distance to Euclid's; at 1 pairs whose centres differ along a diagonal are lost.
template <class S> std::int64_t manhattan_pairs(Items<S> items, S radii, std::vector<BodyPair>& pairs);

template <class S> std::unique_ptr<BroadPhase<S>> make_all_pairs();
template <class S> std::unique_ptr<BroadPhase<S>> make_manhattan();
template <class S> std::unique_ptr<BroadPhase<S>> make_bounding_spheres();
template <class S> std::unique_ptr<BroadPhase<S>> make_sweep_and_prune();
template <class S> std::unique_ptr<BroadPhase<S>> make_grid(Team* team);
template <class S> std::unique_ptr<BroadPhase<S>> make_tree(Team* team);
template <class S> std::unique_ptr<BroadPhase<S>> make_bsp();

}  // namespace atwood::broad
