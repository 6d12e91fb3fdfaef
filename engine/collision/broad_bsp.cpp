// Binary space partitioning: space is cut in two by planes across the axes until few boxes are left in a part. A box
// that a plane cuts goes to both sides; a pair is reported once: in the part that contains the corner
// max(low_a, low_b) of the two boxes' overlap, which lies in exactly one part.
// Source: Fuchs, Kedem, Naylor, On visible surface generation by a priori tree structures (1980); Ericson (2005),
// section 8.3.
#include "collision/broad_kinds.hpp"

namespace atwood::broad {
namespace {

constexpr std::size_t kLeafItems = 32;
constexpr int kMaxCuts = 64;

template <class S> class Bsp final : public BroadPhase<S> {
 public:
  void find(Items<S> items, std::vector<BodyPair>& pairs) override {
    found_.clear();
    this->tested_ = 0;
    stack_.clear();
    for (std::size_t i = 0; i < items.size(); ++i) {
      const Aabb<S>& box = items[i].box;  // boxes with NaN overlap nothing and cannot be sorted
      if (boxes_overlap(box, box)) stack_.push_back(static_cast<std::int32_t>(i));
    }
    constexpr S all = std::numeric_limits<S>::infinity();
    cut(items, 0, stack_.size(), {{-all, -all, -all}, {all, all, all}}, 0);
    pair_sort_.sort(found_, items.size(), pairs);
  }

 private:
  // The items stack_[first .. last) in the part of space `part` (lower ends belong to it, upper ends to the next).
  void cut(Items<S> items, std::size_t first, std::size_t last, const Aabb<S>& part, int cuts) {
    const std::size_t count = last - first;
    if (count < 2) return;
    if (count <= kLeafItems || cuts == kMaxCuts) return test(items, first, last, part);
    // Cut at the median of the lower corners along the axis of their largest extent, or along the next axis if too many
    // boxes would lie on both sides.
    S scatter[3];
    for (int axis = 0; axis < 3; ++axis) {
      S low = std::numeric_limits<S>::infinity(), high = -low;
      for (std::size_t n = first; n < last; ++n) {
        const S x = component(items[stack_[n]].box.low, axis);
        low = std::min(low, x);
        high = std::max(high, x);
      }
      scatter[axis] = high - low;
    }
    int axes[3] = {0, 1, 2};
    std::sort(axes, axes + 3, [&](int a, int b) { return scatter[a] != scatter[b] ? scatter[a] > scatter[b] : a < b; });
    for (const int axis : axes) {
      if (!(scatter[axis] > S(0))) break;  // all lower corners coincide
      const S plane = median(items, first, last, axis);
      const std::size_t left =
          push(items, first, last, [&](const Aabb<S>& box) { return component(box.low, axis) < plane; });
      const std::size_t right =
          push(items, first, last, [&](const Aabb<S>& box) { return component(box.high, axis) >= plane; });
      const std::size_t end = stack_.size();
      if (end - left <= count + count * 5 / 8 && end - right < count) {
        Aabb<S> below = part, above = part;
        (axis == 0 ? below.high.x : axis == 1 ? below.high.y : below.high.z) = plane;
        (axis == 0 ? above.low.x : axis == 1 ? above.low.y : above.low.z) = plane;
        cut(items, left, right, below, cuts + 1);
        cut(items, right, end, above, cuts + 1);
        stack_.resize(left);
        return;
      }
      stack_.resize(left);
    }
    test(items, first, last, part);
  }

  // The median of the lower ends, above the least of them, so that neither side is empty.
  S median(Items<S> items, std::size_t first, std::size_t last, int axis) {
    const auto low_of = [&](std::int32_t i) { return component(items[i].box.low, axis); };
    const auto begin = stack_.begin() + static_cast<std::ptrdiff_t>(first),
               end = stack_.begin() + static_cast<std::ptrdiff_t>(last);
    const auto middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, [&](std::int32_t a, std::int32_t b) { return low_of(a) < low_of(b); });
    const S found = low_of(*middle);
    if (std::any_of(begin, middle, [&](std::int32_t i) { return low_of(i) < found; })) return found;
    S next = std::numeric_limits<S>::infinity();
    for (auto at = middle; at != end; ++at) next = low_of(*at) > found ? std::min(next, low_of(*at)) : next;
    return next;
  }

  // Copies the items of the part that belong to a side to the top of the stack; returns where they begin.
  template <class Belongs>
  std::size_t push(Items<S> items, std::size_t first, std::size_t last, const Belongs& belongs) {
    const std::size_t begin = stack_.size();
    for (std::size_t n = first; n < last; ++n) {
      const std::int32_t item = stack_[n];
      if (belongs(items[item].box)) stack_.push_back(item);
    }
    return begin;
  }

  void test(Items<S> items, std::size_t first, std::size_t last, const Aabb<S>& part) {
    for (std::size_t n = first; n < last; ++n) {
      for (std::size_t m = n + 1; m < last; ++m) {
        const std::int32_t a = stack_[n], b = stack_[m];
        ++this->tested_;
        if (is_pair(items[a], items[b]) && inside(overlap_corner(items[a].box, items[b].box), part))
          found_.push_back(ordered(a, b));
      }
    }
  }

  static Vec3<S> overlap_corner(const Aabb<S>& a, const Aabb<S>& b) {
    return {std::max(a.low.x, b.low.x), std::max(a.low.y, b.low.y), std::max(a.low.z, b.low.z)};
  }
  static bool inside(const Vec3<S>& p, const Aabb<S>& part) {
    return p.x >= part.low.x && p.x < part.high.x && p.y >= part.low.y && p.y < part.high.y && p.z >= part.low.z &&
           p.z < part.high.z;
  }

  std::vector<std::int32_t> stack_;  // the items of every part that is being cut, deepest last
  std::vector<BodyPair> found_;
  PairSort pair_sort_;
};

}  // namespace

template <class S> std::unique_ptr<BroadPhase<S>> make_bsp() { return std::make_unique<Bsp<S>>(); }
template std::unique_ptr<BroadPhase<float>> make_bsp();
template std::unique_ptr<BroadPhase<double>> make_bsp();

}  // namespace atwood::broad
