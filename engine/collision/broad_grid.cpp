// Uniform grid, hashed: boxes sorted by the cell of their lower corner, each cell tested against itself and half of its
// neighbours. Source: Teschner, Heidelberger, Mueller, Pomeranets, Gross, Optimized spatial hashing for collision
// detection (2003).
//
// With cells at least as wide as every box two boxes that overlap have lower corners in the same cell or in
// neighbouring ones: low_a <= high_b <= low_b + cell. Boxes of more than twice the median width do not set the cell
// size: they are tested against all.
#include <bit>
#include <cmath>

#include "collision/broad_kinds.hpp"

namespace atwood::broad {
namespace {

template <class S> class Grid final : public BroadPhase<S> {
 public:
  explicit Grid(Team* team) : team_(team), found_(team ? static_cast<std::size_t>(team->size()) : 1) {}

  void find(Items<S> items, std::vector<BodyPair>& pairs) override {
    choose_cell(items);
    sort_into_cells(items);
    const int parts = static_cast<int>(found_.size());
    const int count = static_cast<int>(sorted_.size());
    const auto search = [&](int part) {
      const Share mine = share(count, part, parts);
      Found& found = found_[static_cast<std::size_t>(part)];
      found.pairs.clear();
      found.tested = 0;
      for (int at = mine.first; at < mine.last; ++at) search_from(items, static_cast<std::size_t>(at), found);
      const Share large = share(static_cast<int>(large_.size()), part, parts);
      for (int at = large.first; at < large.last; ++at)
        search_large(items, large_[static_cast<std::size_t>(at)], found);
    };
    if (team_) team_->run(count > 1000, search);
    else search(0);
    all_found_.clear();
    this->tested_ = 0;
    for (const Found& found : found_) {
      all_found_.insert(all_found_.end(), found.pairs.begin(), found.pairs.end());
      this->tested_ += found.tested;
    }
    pair_sort_.sort(all_found_, items.size(), pairs);
  }

 private:
  using Cell = std::int64_t;
  struct GridItem {
    Cell i, j, k;
    std::int32_t item;
  };
  struct Found {
    std::vector<BodyPair> pairs;
    std::int64_t tested = 0;
  };

  static double width(const BroadItem<S>& item) {
    const Aabb<S>& box = item.box;
    return std::max({static_cast<double>(box.high.x) - static_cast<double>(box.low.x),
                     static_cast<double>(box.high.y) - static_cast<double>(box.low.y),
                     static_cast<double>(box.high.z) - static_cast<double>(box.low.z)});
  }
  static bool finite(const BroadItem<S>& item) {
    const Aabb<S>& box = item.box;
    const double all = std::abs(double(box.low.x)) + std::abs(double(box.low.y)) + std::abs(double(box.low.z)) +
                       std::abs(double(box.high.x)) + std::abs(double(box.high.y)) + std::abs(double(box.high.z));
    return all - all == 0;
  }

  // A corner's cell is floor(x / cell), a quotient that rounding moves by |x / cell| 2^-52 or so. The margin of 2^-10
  // on the cell covers that as long as |x / cell| < 2^40, which the last line ensures; with points alone it also
  // keeps the cell above 0.
  void choose_cell(Items<S> items) {
    widths_.clear();
    double farthest = 0;
    for (const BroadItem<S>& item : items) {
      if (!finite(item)) continue;
      widths_.push_back(width(item));
      for (int axis = 0; axis < 3; ++axis)
        farthest = std::max(farthest, std::abs(static_cast<double>(component(item.box.low, axis))));
    }
    double widest = 0;
    if (!widths_.empty()) {
      const auto middle = widths_.begin() + static_cast<std::ptrdiff_t>(widths_.size() / 2);
      std::nth_element(widths_.begin(), middle, widths_.end());
      max_small_width_ = 2 * *middle;
      for (const double w : widths_) widest = w <= max_small_width_ ? std::max(widest, w) : widest;
    }
    cell_m_ = std::max({widest * (1 + 0x1p-10), farthest * 0x1p-40, std::numeric_limits<double>::min()});
  }

  // Eight cells in a row along x stay together, so that neighbours are mostly near in memory; the blocks are scattered.
  std::size_t bucket(Cell i, Cell j, Cell k) const {
    const std::uint64_t mixed = static_cast<std::uint64_t>(i >> 3) * 0x9e3779b97f4a7c15u +
                                static_cast<std::uint64_t>(j) * 0xc2b2ae3d27d4eb4fu +
                                static_cast<std::uint64_t>(k) * 0x165667b19e3779f9u;
    return static_cast<std::size_t>((mixed ^ mixed >> 29) * 0xbf58476d1ce4e5b9u >> shift_ << 3) |
           static_cast<std::size_t>(i & 7);
  }

  // Counting sort by bucket; within one, by index.
  void sort_into_cells(Items<S> items) {
    const std::size_t buckets = std::bit_ceil(std::max<std::size_t>(16, 2 * items.size()));
    shift_ = 64 + 3 - std::countr_zero(buckets);
    bucket_end_.assign(buckets + 1, 0);
    small_.clear();
    large_.clear();
    for (std::size_t n = 0; n < items.size(); ++n) {
      const BroadItem<S>& item = items[n];
      if (!finite(item) || !(width(item) <= max_small_width_)) {
        large_.push_back(static_cast<std::int32_t>(n));
        continue;
      }
      const auto cell = [&](S x) { return static_cast<Cell>(std::floor(static_cast<double>(x) / cell_m_)); };
      small_.push_back(
          {cell(item.box.low.x), cell(item.box.low.y), cell(item.box.low.z), static_cast<std::int32_t>(n)});
      ++bucket_end_[bucket(small_.back().i, small_.back().j, small_.back().k) + 1];
    }
    for (std::size_t b = 0; b < buckets; ++b) bucket_end_[b + 1] += bucket_end_[b];
    sorted_.resize(small_.size());
    for (const GridItem& f : small_) sorted_[static_cast<std::size_t>(bucket_end_[bucket(f.i, f.j, f.k)]++)] = f;
    // b begins at bucket_end_[b - 1]
  }

  void test_pair(Items<S> items, std::int32_t a, std::int32_t b, Found& found) const {
    ++found.tested;
    if (is_pair(items[a], items[b])) found.pairs.push_back(ordered(a, b));
  }

  void search_from(Items<S> items, std::size_t at, Found& found) const {
    const GridItem mine = sorted_[at];
    const auto same = [](const GridItem& f, Cell i, Cell j, Cell k) { return f.i == i && f.j == j && f.k == k; };
    const auto own_end = static_cast<std::size_t>(bucket_end_[bucket(mine.i, mine.j, mine.k)]);
    for (std::size_t other = at + 1; other < own_end; ++other) {
      if (same(sorted_[other], mine.i, mine.j, mine.k)) test_pair(items, mine.item, sorted_[other].item, found);
    }
    for (int dk = 0; dk <= 1; ++dk) {  // the 13 of the 26 neighbours that come later in the order of (k, j, i)
      for (int dj = dk == 0 ? 0 : -1; dj <= 1; ++dj) {
        for (int di = dk == 0 && dj == 0 ? 1 : -1; di <= 1; ++di) {
          const Cell i = mine.i + di, j = mine.j + dj, k = mine.k + dk;
          const std::size_t b = bucket(i, j, k);
          for (std::int32_t other = b == 0 ? 0 : bucket_end_[b - 1]; other < bucket_end_[b]; ++other) {
            const GridItem& f = sorted_[static_cast<std::size_t>(other)];
            if (same(f, i, j, k)) test_pair(items, mine.item, f.item, found);
          }
        }
      }
    }
  }

  void search_large(Items<S> items, std::int32_t a, Found& found) const {
    for (const GridItem& f : small_) test_pair(items, a, f.item, found);
    for (const std::int32_t b : large_) {
      if (a < b) test_pair(items, a, b, found);
    }
  }

  Team* team_;
  std::vector<Found> found_;  // one per part
  std::vector<double> widths_;
  double cell_m_ = 1, max_small_width_ = 0;
  int shift_ = 60;
  std::vector<std::int32_t> bucket_end_, large_;
  std::vector<GridItem> small_, sorted_;
  std::vector<BodyPair> all_found_;
  PairSort pair_sort_;
};

}  // namespace

template <class S> std::unique_ptr<BroadPhase<S>> make_grid(Team* team) { return std::make_unique<Grid<S>>(team); }
template std::unique_ptr<BroadPhase<float>> make_grid(Team*);
template std::unique_ptr<BroadPhase<double>> make_grid(Team*);

}  // namespace atwood::broad
