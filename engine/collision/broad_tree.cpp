// Dynamic tree of bounding boxes. Each item has a fat box and a fat sphere, grown by a little and along its motion;
// pairs whose fat boxes and spheres overlap are stored as candidates. A call in which every item is still inside its
// fat box and sphere only tests the candidates; if a few have left theirs, the tree is queried for those; if many, for
// all.
// Source: Catto, Dynamic bounding volume hierarchies (2019), for the fat boxes. The tree is refitted in place, and
// rebuilt by splits at medians when a search visits 1.5 times as many nodes as it did just after the last rebuild.
#include "collision/broad_kinds.hpp"

namespace atwood::broad {
namespace {

constexpr int kLeafItems = 4;

template <class S> class Tree final : public BroadPhase<S> {
 public:
  explicit Tree(Team* team) : team_(team), found_(team ? static_cast<std::size_t>(team->size()) : 1) {}

  void find(Items<S> items, std::vector<BodyPair>& pairs) override {
    ++call_;
    const std::size_t n = items.size();
    bool rebuild_needed = fat_.size() != n;
    if (rebuild_needed) clear(items);
    find_escaped(items, rebuild_needed);
    if (rebuild_needed || escaped_.size() * 8 > n) {
      search_all(items);
    } else if (!escaped_.empty()) {
      search_escaped(items);
    }
    this->tested_ = static_cast<std::int64_t>(candidates_.size());
    filter_candidates(items, pairs);
  }

 private:
  // In preorder; `skip`: the next node that is not below this one
  struct Node {
    Aabb<S> box;
    std::int32_t skip, first, count;
  };
  struct Entry {
    Vec3<S> middle;
    std::int32_t item;
  };
  struct Fat {
    Aabb<S> box;
    Vec3<S> center;
    S radius;
  };
  // Low corner of the item's box, and the number of the call, when its fat box was made.
  struct FatOrigin {
    Vec3<S> low;
    std::int64_t call;
  };
  struct Found {
    std::vector<BodyPair> pairs, decided;
    std::int64_t visits = 0;
  };

  static bool within(const BroadItem<S>& item, const Fat& fat) {
    const Aabb<S>&inner = item.box, &outer = fat.box;
    const Vec3<S> d = item.center - fat.center;
    const S slack = fat.radius - item.radius;
    return (outer.low.x <= inner.low.x) & (outer.low.y <= inner.low.y) & (outer.low.z <= inner.low.z) &
           (inner.high.x <= outer.high.x) & (inner.high.y <= outer.high.y) & (inner.high.z <= outer.high.z) &
           (slack >= S(0)) & (dot(d, d) <= slack * slack);
  }
  // Spheres inside fat spheres that do not overlap do not overlap, by the triangle inequality
  //   |F_a - F_b| <= |F_a - c_a| + |c_a - c_b| + |c_b - F_b|.
  // Each of the three comparisons is off by a few units in the last place of what it compares, hence the factor.
  static bool fat_overlap(const Fat& a, const Fat& b) {
    const Vec3<S> d = b.center - a.center;
    const S radii = (S(1) + S(32) * std::numeric_limits<S>::epsilon()) * (a.radius + b.radius);
    return boxes_overlap(a.box, b.box) & !(dot(d, d) > radii * radii);
  }
  static void merge(Aabb<S>& box, const Aabb<S>& other) {
    box.low = {std::min(box.low.x, other.low.x), std::min(box.low.y, other.low.y), std::min(box.low.z, other.low.z)};
    box.high = {std::max(box.high.x, other.high.x), std::max(box.high.y, other.high.y),
                std::max(box.high.z, other.high.z)};
  }
  static Aabb<S> empty_box() {
    constexpr S far = std::numeric_limits<S>::infinity();
    return {{far, far, far}, {-far, -far, -far}};
  }

  void clear(Items<S> items) {
    fat_.resize(items.size());
    moves_.resize(items.size());
    origin_.assign(items.size(), {{}, -1});
    nodes_.clear();
  }

  // Lists items outside their fat volume; `rebuild_needed` is set if some item began or ceased to move.
  void find_escaped(Items<S> items, bool& rebuild_needed) {
    escaped_.clear();
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (rebuild_needed || !within(items[i], fat_[i])) escaped_.push_back(static_cast<std::int32_t>(i));
      rebuild_needed = rebuild_needed || (moves_[i] != 0) != items[i].moves;
    }
  }

  // Enlarges the box by a twentieth of its side, and by three calls of its mean motion since the last fat box, at most
  // by its own side.
  void fatten(Items<S> items, std::int32_t i) {
    const BroadItem<S>& item = items[i];
    FatOrigin& origin = origin_[i];
    const S calls = S(call_ - origin.call);
    Fat& fat = fat_[i];
    fat = {item.box, item.center, item.radius};
    const auto grow = [&](S low, S high, S origin_low, S& fat_low, S& fat_high, S& center) {
      const S side = high - low;
      S ahead = origin.call < 0 ? S(0) : S(3) * (low - origin_low) / calls;
      ahead = std::max(-side, std::min(side, ahead));
      const S margin = S(0.05) * side;
      fat_low = low - margin + std::min(ahead, S(0));
      fat_high = high + margin + std::max(ahead, S(0));
      center += ahead / S(2);
      return ahead;
    };
    if (item.moves) {
      Vec3<S> ahead;
      ahead.x = grow(item.box.low.x, item.box.high.x, origin.low.x, fat.box.low.x, fat.box.high.x, fat.center.x);
      ahead.y = grow(item.box.low.y, item.box.high.y, origin.low.y, fat.box.low.y, fat.box.high.y, fat.center.y);
      ahead.z = grow(item.box.low.z, item.box.high.z, origin.low.z, fat.box.low.z, fat.box.high.z, fat.center.z);
      fat.radius += S(0.1) * item.radius + norm(ahead) / S(2);  // covers the margins of cubes: sqrt(3) 0.05 of the side
    }
    origin = {item.box.low, call_};
    moves_[i] = item.moves;
  }

  // ---- the tree ---------------------------------------------------------------------------------------------------
  void build() {
    const auto n = static_cast<std::int32_t>(fat_.size());
    entries_.resize(fat_.size());
    for (std::int32_t i = 0; i < n; ++i) {
      const Vec3<S> sum = fat_[i].box.low + fat_[i].box.high;  // twice the middle
      entries_[i] = {{sortable(sum.x), sortable(sum.y), sortable(sum.z)}, i};
    }
    nodes_.clear();
    leaves_.clear();
    if (n > 0) split(0, n);
    packed_.resize(fat_.size());
  }

  void split(std::int32_t first, std::int32_t last) {
    const std::size_t node = nodes_.size();
    nodes_.push_back({{}, 0, first, last - first});
    if (last - first <= kLeafItems) {
      leaves_.push_back(static_cast<std::int32_t>(node));
    } else {
      nodes_[node].count = 0;
      const int axis = widest_axis(first, last);
      const std::int32_t middle = first + (last - first) / 2;
      std::nth_element(entries_.begin() + first, entries_.begin() + middle, entries_.begin() + last,
                       [axis](const Entry& a, const Entry& b) {
                         const S x = component(a.middle, axis), y = component(b.middle, axis);
                         return x != y ? x < y : a.item < b.item;
                       });
      split(first, middle);
      split(middle, last);
    }
    nodes_[node].skip = static_cast<std::int32_t>(nodes_.size());
  }

  int widest_axis(std::int32_t first, std::int32_t last) const {
    Vec3<S> low = entries_[first].middle, high = low;
    for (std::int32_t k = first + 1; k < last; ++k) {
      const Vec3<S>& x = entries_[k].middle;
      low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)};
      high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
    }
    const Vec3<S> d = high - low;
    return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
  }

  // Boxes from the leaves up: in preorder both children come after their parent.
  void refit() {
    for (std::size_t k = 0; k < entries_.size(); ++k) packed_[k] = fat_[entries_[k].item];
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      Node& node = nodes_[i];
      node.box = empty_box();
      for (std::int32_t k = node.first; k < node.first + node.count; ++k) merge(node.box, packed_[k].box);
      if (node.count > 0) continue;
      merge(node.box, nodes_[i + 1].box);
      merge(node.box, nodes_[nodes_[i + 1].skip].box);
    }
  }

  // ---- candidates -------------------------------------------------------------------------------------------------
  void search_all(Items<S> items) {
    for (std::size_t i = 0; i < items.size(); ++i) fatten(items, static_cast<std::int32_t>(i));
    const bool rebuild = nodes_.empty() || visits_ > visits_after_building_ + visits_after_building_ / 2;
    if (rebuild) build();
    refit();
    const int parts = static_cast<int>(found_.size());
    const auto work = [&](int part) {
      const Share mine = share(static_cast<int>(leaves_.size()), part, parts);
      Found& found = found_[part];
      found.pairs.clear();
      found.visits = 0;
      for (int leaf = mine.first; leaf < mine.last; ++leaf) search_from_leaf(leaves_[leaf], found);
    };
    if (team_) team_->run(items.size() > 500, work);
    else work(0);
    scratch_.clear();
    visits_ = 0;
    for (const Found& found : found_) {
      scratch_.insert(scratch_.end(), found.pairs.begin(), found.pairs.end());
      visits_ += found.visits;
    }
    if (rebuild) visits_after_building_ = visits_;
    pair_sort_.sort(scratch_, items.size(), candidates_);
  }

  void add_candidate(std::int32_t a, std::int32_t b, Found& found) const {
    if (moves_[a] | moves_[b]) found.pairs.push_back(ordered(a, b));
  }

  // A leaf's items among each other, and with those of leaves later in preorder: each pair of leaves once.
  void search_from_leaf(std::int32_t at, Found& found) const {
    const Node& mine = nodes_[at];
    const std::int32_t end = mine.first + mine.count;
    for (std::int32_t k = mine.first; k < end; ++k) {
      for (std::int32_t l = k + 1; l < end; ++l) {
        if (fat_overlap(packed_[k], packed_[l])) add_candidate(entries_[k].item, entries_[l].item, found);
      }
    }
    const auto last = static_cast<std::int32_t>(nodes_.size());
    for (std::int32_t other = mine.skip; other < last;) {
      const Node& node = nodes_[other];
      ++found.visits;
      if (!boxes_overlap(mine.box, node.box)) {
        other = node.skip;
        continue;
      }
      for (std::int32_t l = node.first; l < node.first + node.count; ++l) {
        if (!boxes_overlap(mine.box, packed_[l].box)) continue;
        for (std::int32_t k = mine.first; k < end; ++k) {
          if (fat_overlap(packed_[k], packed_[l])) add_candidate(entries_[k].item, entries_[l].item, found);
        }
      }
      ++other;
    }
  }

  // New fat boxes for the items that left theirs; their candidates are searched again, all others stay.
  void search_escaped(Items<S> items) {
    has_escaped_.assign(items.size(), 0);
    for (const std::int32_t i : escaped_) {
      fatten(items, i);
      has_escaped_[i] = 1;
    }
    refit();
    Found& found = found_[0];
    found.pairs.clear();
    for (const std::int32_t i : escaped_) search_from_item(i, found);
    pair_sort_.sort(found.pairs, items.size(), new_);
    scratch_.clear();
    auto next_new = new_.begin();
    for (const BodyPair& old : candidates_) {
      if (has_escaped_[old.first] | has_escaped_[old.second]) continue;
      while (next_new != new_.end() && *next_new < old) scratch_.push_back(*next_new++);
      scratch_.push_back(old);
    }
    scratch_.insert(scratch_.end(), next_new, new_.end());
    candidates_.swap(scratch_);
  }

  void search_from_item(std::int32_t i, Found& found) const {
    const Fat fat = fat_[i];
    const auto last = static_cast<std::int32_t>(nodes_.size());
    for (std::int32_t at = 0; at < last;) {
      const Node& node = nodes_[at];
      if (!boxes_overlap(fat.box, node.box)) {
        at = node.skip;
        continue;
      }
      for (std::int32_t k = node.first; k < node.first + node.count; ++k) {
        const std::int32_t other = entries_[k].item;
        if (other == i || (has_escaped_[other] && other < i)) continue;  // a pair of two escaped items is added once
        if (fat_overlap(fat, packed_[k])) add_candidate(i, other, found);
      }
      ++at;
    }
  }

  // Candidates are sorted, and so are the pairs among them.
  void filter_candidates(Items<S> items, std::vector<BodyPair>& pairs) {
    const int parts = static_cast<int>(found_.size());
    const auto work = [&](int part) {
      const Share mine = share(static_cast<int>(candidates_.size()), part, parts);
      std::vector<BodyPair>& out = parts == 1 ? pairs : found_[part].decided;
      out.resize(static_cast<std::size_t>(mine.last - mine.first));
      std::size_t count = 0;
      for (int k = mine.first; k < mine.last; ++k) {  // always written, counted only if it is a pair: no branch
        const BodyPair pair = candidates_[k];
        out[count] = pair;
        count += is_pair(items[pair.first], items[pair.second]);
      }
      out.resize(count);
    };
    if (team_) team_->run(candidates_.size() > 10000, work);
    else work(0);
    if (parts == 1) return;
    pairs.clear();
    for (const Found& found : found_) pairs.insert(pairs.end(), found.decided.begin(), found.decided.end());
  }

  Team* team_;
  std::int64_t call_ = 0, visits_ = 0, visits_after_building_ = 0;
  std::vector<Fat> fat_, packed_;  // by item; in the order of the leaves
  std::vector<FatOrigin> origin_;
  std::vector<char> moves_, has_escaped_;
  std::vector<std::int32_t> escaped_, leaves_;
  std::vector<Entry> entries_;
  std::vector<Node> nodes_;
  std::vector<Found> found_;  // a part each
  std::vector<BodyPair> candidates_, new_, scratch_;
  PairSort pair_sort_;
};

}  // namespace

template <class S> std::unique_ptr<BroadPhase<S>> make_tree(Team* team) { return std::make_unique<Tree<S>>(team); }
template std::unique_ptr<BroadPhase<float>> make_tree(Team*);
template std::unique_ptr<BroadPhase<double>> make_tree(Team*);

}  // namespace atwood::broad
