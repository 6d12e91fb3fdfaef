// Sweep and prune along one axis: boxes in the order of their lower ends, each against those that begin before it ends.
// Source: Baraff, Dynamic simulation of non-penetrating rigid bodies (1992), section 4; one axis, the order kept from
// call to call.
#include "collision/broad_kinds.hpp"

namespace atwood::broad {
namespace {

template <class S> class Sweep final : public BroadPhase<S> {
 public:
  void find(Items<S> items, std::vector<BodyPair>& pairs) override {
    const int axis = widest_axis(items);
    const std::size_t n = items.size();
    if (order_.size() != n) {
      order_.resize(n);
      for (std::size_t i = 0; i < n; ++i) order_[i].item = static_cast<std::int32_t>(i);
    }
    for (Entry& e : order_) {
      const Aabb<S>& box = items[e.item].box;
      e.low = sortable(component(box.low, axis));
      e.high = component(box.high, axis);
    }
    sort(axis);
    found_.clear();
    this->tested_ = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const BroadItem<S>& a = items[order_[i].item];
      for (std::size_t j = i + 1; j < n && order_[j].low <= order_[i].high; ++j) {
        ++this->tested_;
        if (is_pair(a, items[order_[j].item])) found_.push_back(ordered(order_[i].item, order_[j].item));
      }
    }
    pair_sort_.sort(found_, n, pairs);
  }

 private:
  struct Entry {
    S low, high;
    std::int32_t item;
  };

  // The axis along which the variance of the finite centres is largest; sums in double.
  static int widest_axis(Items<S> items) {
    double sum[3] = {}, squares[3] = {}, count = 0;
    for (const BroadItem<S>& item : items) {
      const double x[3] = {static_cast<double>(item.center.x), static_cast<double>(item.center.y),
                           static_cast<double>(item.center.z)};
      const double all = x[0] + x[1] + x[2];
      if (!(all - all == 0)) continue;
      ++count;
      for (int k = 0; k < 3; ++k) sum[k] += x[k], squares[k] += x[k] * x[k];
    }
    int widest = 0;
    double most = -1;
    for (int k = 0; k < 3; ++k) {
      const double variance = count > 0 ? squares[k] - sum[k] * sum[k] / count : 0;
      if (variance > most) most = variance, widest = k;
    }
    return widest;
  }

  // Insertion sort while little has changed since the last call; a full sort otherwise.
  void sort(int axis) {
    const auto before = [](const Entry& a, const Entry& b) { return a.low != b.low ? a.low < b.low : a.item < b.item; };
    const bool fresh = axis != axis_;
    axis_ = axis;
    std::size_t budget = fresh ? 0 : 8 * order_.size();
    for (std::size_t i = 1; i < order_.size(); ++i) {
      const Entry entry = order_[i];
      std::size_t at = i;
      for (; at > 0 && budget > 0 && before(entry, order_[at - 1]); --at, --budget) order_[at] = order_[at - 1];
      order_[at] = entry;
      if (budget == 0) return std::sort(order_.begin(), order_.end(), before);
    }
  }

  std::vector<Entry> order_;
  int axis_ = -1;
  std::vector<BodyPair> found_;
  PairSort pair_sort_;
};

}  // namespace

template <class S> std::unique_ptr<BroadPhase<S>> make_sweep_and_prune() { return std::make_unique<Sweep<S>>(); }
template std::unique_ptr<BroadPhase<float>> make_sweep_and_prune();
template std::unique_ptr<BroadPhase<double>> make_sweep_and_prune();

}  // namespace atwood::broad
