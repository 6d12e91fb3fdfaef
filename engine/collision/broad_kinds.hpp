// What the broad phases share: the test that decides, the sort of what was found, and a maker for each kind.
#pragma once

#include <algorithm>
#include <limits>

#include "collision/broad_phase.hpp"
#include "parallel/team.hpp"

namespace atwood::broad {

template <class S> using Items = std::span<const BroadItem<S>>;

template <class S> inline S along(const Vec3<S>& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

// Touching counts; whoever is not a number meets nobody.
template <class S> inline bool boxes_overlap(const Aabb<S>& a, const Aabb<S>& b) {
  return (a.low.x <= b.high.x) & (b.low.x <= a.high.x) & (a.low.y <= b.high.y) & (b.low.y <= a.high.y) &
         (a.low.z <= b.high.z) & (b.low.z <= a.high.z);
}
template <class S> inline bool spheres_overlap(const BroadItem<S>& a, const BroadItem<S>& b) {
  const Vec3<S> d = b.center - a.center;
  const S reach = a.radius + b.radius;
  return dot(d, d) <= reach * reach;
}
template <class S> inline bool is_pair(const BroadItem<S>& a, const BroadItem<S>& b) {
  return (a.moves | b.moves) & boxes_overlap(a.box, b.box) & spheres_overlap(a, b);
}

inline BodyPair ordered(std::int32_t a, std::int32_t b) { return a < b ? BodyPair(a, b) : BodyPair(b, a); }

// Where a sort may put it: what is not a number comes last, and so keeps the order a strict one.
template <class S> inline S sortable(S x) { return x == x ? x : std::numeric_limits<S>::infinity(); }

// Pairs of 0 .. count - 1, as found, into the order of BodyPair: by counting over the first index, then each one's few
// partners.
class PairSort {
 public:
  void sort(const std::vector<BodyPair>& found, std::size_t count, std::vector<BodyPair>& pairs);

 private:
  std::vector<std::int32_t> start_;
};

// ---- the kinds ----------------------------------------------------------------------------------------------------
// Pairs whose centres are at most `reach` (r_a + r_b) apart in the sum of the coordinates' differences. No true pair is
// lost at reach = sqrt(3), the largest ratio of that distance to Euclid's; at reach = 1 pairs that meet askew are.
template <class S> std::int64_t manhattan_pairs(Items<S> items, S reach, std::vector<BodyPair>& pairs);

template <class S> std::unique_ptr<BroadPhase<S>> make_all_pairs();
template <class S> std::unique_ptr<BroadPhase<S>> make_manhattan();
template <class S> std::unique_ptr<BroadPhase<S>> make_bounding_spheres();
template <class S> std::unique_ptr<BroadPhase<S>> make_sweep_and_prune();
template <class S> std::unique_ptr<BroadPhase<S>> make_grid(Team* team);
template <class S> std::unique_ptr<BroadPhase<S>> make_tree(Team* team);
template <class S> std::unique_ptr<BroadPhase<S>> make_bsp();

}  // namespace atwood::broad
