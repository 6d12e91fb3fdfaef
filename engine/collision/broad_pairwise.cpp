// Broad phases that test every pair, O(N^2), each with a cheap test of its own before boxes and spheres are compared.
#include <cmath>

#include "collision/broad_kinds.hpp"

namespace atwood::broad {
namespace {

// `near` is the kind's own test; pairs that pass it are candidates.
template <class S, class Near> std::int64_t every_pair(Items<S> items, std::vector<BodyPair>& pairs, const Near& near) {
  std::int64_t tested = 0;
  pairs.clear();
  const auto n = static_cast<std::int32_t>(items.size());
  for (std::int32_t a = 0; a < n; ++a) {
    for (std::int32_t b = a + 1; b < n; ++b) {
      if (!near(items[a], items[b])) continue;
      ++tested;
      if (is_pair(items[a], items[b])) pairs.emplace_back(a, b);
    }
  }
  return tested;
}

template <class S> class AllPairs final : public BroadPhase<S> {
  void find(Items<S> items, std::vector<BodyPair>& pairs) override {
    this->tested_ = every_pair<S>(items, pairs, [](const auto&, const auto&) { return true; });
  }
};

template <class S> class Manhattan final : public BroadPhase<S> {
  void find(Items<S> items, std::vector<BodyPair>& pairs) override {
    this->tested_ = manhattan_pairs(items, std::sqrt(S(3)), pairs);
  }
};

template <class S> class BoundingSpheres final : public BroadPhase<S> {
  void find(Items<S> items, std::vector<BodyPair>& pairs) override {
    this->tested_ = every_pair<S>(items, pairs, [](const auto& a, const auto& b) { return spheres_overlap(a, b); });
  }
};

}  // namespace

// |x| + |y| + |z| <= sqrt(3) sqrt(x^2 + y^2 + z^2) (Cauchy and Schwarz, with equality on the diagonals); the few units
// in the last place cover the rounding of both sides, so that every pair that passes spheres_overlap passes this test
// too.
template <class S> std::int64_t manhattan_pairs(Items<S> items, S radii, std::vector<BodyPair>& pairs) {
  const S widened = radii * (S(1) + S(8) * std::numeric_limits<S>::epsilon());
  return every_pair<S>(items, pairs, [widened](const BroadItem<S>& a, const BroadItem<S>& b) {
    const Vec3<S> d = b.center - a.center;
    return std::abs(d.x) + std::abs(d.y) + std::abs(d.z) <= widened * (a.radius + b.radius);
  });
}

template <class S> std::unique_ptr<BroadPhase<S>> make_all_pairs() { return std::make_unique<AllPairs<S>>(); }
template <class S> std::unique_ptr<BroadPhase<S>> make_manhattan() { return std::make_unique<Manhattan<S>>(); }
template <class S> std::unique_ptr<BroadPhase<S>> make_bounding_spheres() {
  return std::make_unique<BoundingSpheres<S>>();
}

template std::int64_t manhattan_pairs(Items<float>, float, std::vector<BodyPair>&);
template std::int64_t manhattan_pairs(Items<double>, double, std::vector<BodyPair>&);
template std::unique_ptr<BroadPhase<float>> make_all_pairs();
template std::unique_ptr<BroadPhase<double>> make_all_pairs();
template std::unique_ptr<BroadPhase<float>> make_manhattan();
template std::unique_ptr<BroadPhase<double>> make_manhattan();
template std::unique_ptr<BroadPhase<float>> make_bounding_spheres();
template std::unique_ptr<BroadPhase<double>> make_bounding_spheres();

}  // namespace atwood::broad
