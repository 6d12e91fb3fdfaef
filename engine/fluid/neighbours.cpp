#include "fluid/neighbours.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

#include "math/vector_width.hpp"

namespace atwood::fluid {
namespace {

constexpr int kMinShared = 2000;  // points: below, starting the team costs more than it saves

int whole_blocks(int count) { return (count + kLaneCount - 1) / kLaneCount; }

int parts_of(const Team* team, int points) { return team == nullptr || points < kMinShared ? 1 : team->size(); }

// Whether some point of [first, last) has moved farther than the root of `most2`, or is not finite.
template <int d, class S> bool beyond(const S* x, const S* before, int first, int last, S most2) {
  int far = 0;
  for (std::ptrdiff_t i = first; i < last; ++i) {
    S moved2{};
    for (int c = 0; c < d; ++c) moved2 += (x[i * d + c] - before[i * d + c]) * (x[i * d + c] - before[i * d + c]);
    far |= moved2 <= most2 ? 0 : 1;
  }
  return far != 0;
}

}  // namespace

template <class S>
Neighbours<S>::Neighbours(const Domain& domain, S support, S skin)
    : dimensions_(domain.dimensions), support_(support), skin_(skin) {
  for (int axis = 0; axis < dimensions_; ++axis) {
    period_[axis] = S(domain.periodic_m[axis]);
    inverse_period_[axis] = period_[axis] > S(0) ? S(1) / period_[axis] : S(0);
  }
}

template <class S>
Neighbours<S>::Neighbours(const Domain& domain, S support, S skin, S spacing) : Neighbours(domain, support, skin) {
  spacing_ = spacing;
}

// work(range, part) for all points: one range, or one for each member of the team.
template <class S> template <class Work> void Neighbours<S>::over_points(int count, Team* team, const Work& work) {
  const int parts = parts_of(team, count);
  if (parts == 1) return work(Share{0, count}, 0);
  team->run(parts, [&](int part) { work(share(count, part, parts), part); });
}

template <class S> bool Neighbours<S>::update(const S* x, int count, Team* team) {
  if (built_count_ == count) {
    const S most2 = S(0.25) * skin_ * skin_;
    std::atomic<bool> stale{false};
    over_points(count, team, [&](Share own, int) {
      const bool far = dimensions_ == 2 ? beyond<2>(x, built_at_.data(), own.first, own.last, most2)
                                        : beyond<3>(x, built_at_.data(), own.first, own.last, most2);
      if (far) stale.store(true, std::memory_order_relaxed);
    });
    if (!stale) return true;
  }
  std::atomic<bool> finite{true};
  over_points(count, team, [&](Share own, int) {
    for (std::ptrdiff_t i = std::ptrdiff_t(own.first) * dimensions_; i < std::ptrdiff_t(own.last) * dimensions_; ++i)
      if (!real::is_finite(x[i])) return finite.store(false, std::memory_order_relaxed);
  });
  if (!finite) return false;
  build(x, count, team);
  return true;
}

template <class S> void Neighbours<S>::build(const S* x, int count, Team* team) {
  ++builds_;
  built_count_ = count;
  const int padded = whole_blocks(count) * kLaneCount;
  built_at_.resize(std::size_t(dimensions_) * count);
  wrapped_.resize(built_at_.size());
  order_.resize(count);
  slot_of_.resize(count);
  cell_of_.resize(count);
  sorted_.resize(dimensions_ * stride());
  if (!of_blocks()) counts_.resize(padded);
  block_longest_.resize(padded / kLaneCount);
  block_wraps_.resize(padded / kLaneCount);
  over_points(count, team, [&](Share own, int) {
    for (std::ptrdiff_t i = own.first; i < own.last; ++i)
      for (int axis = 0; axis < dimensions_; ++axis) {
        const std::ptrdiff_t at = i * dimensions_ + axis;
        built_at_[at] = x[at];
        wrapped_[at] = wrapped(x[at], axis);
      }
  });
  const Grid grid = make_grid();
  sort_into_cells(grid, team);
  const int blocks = padded / kLaneCount, parts = parts_of(team, count);
  for (;;) {
    entries_.resize(std::size_t(blocks) * lists_a_block() * capacity_);
    std::atomic<bool> fits{true};
    const auto work = [&](int part) {
      const Share own = share(blocks, part, parts);
      if (fill_lists(grid, own.first * kLaneCount, std::min(own.last * kLaneCount, count)))
        finish_blocks(own.first, own.last);
      else fits.store(false, std::memory_order_relaxed);
    };
    if (parts == 1) work(0);
    else team->run(parts, work);
    if (fits) return;
    capacity_ += std::max(kLaneCount, capacity_ / 4);
    entries_.clear();
  }
}

// Rows of cells as wide as the list radius, or as a cube that holds a block's points; the cells along a row a quarter
// of it; wider where that would be many more cells than points, however far these are apart.
template <class S> auto Neighbours<S>::make_grid() const -> Grid {
  Grid grid;
  const S list_radius = support_ + skin_;
  const int count = static_cast<int>(order_.size());
  S extent[3]{};
  for (int axis = 0; axis < dimensions_; ++axis) {
    S least = S(0), most = period_[axis];
    if (most == S(0)) {
      least = most = wrapped_[axis];
      for (std::size_t i = axis; i < wrapped_.size(); i += dimensions_) {
        least = real::min(least, wrapped_[i]);
        most = real::max(most, wrapped_[i]);
      }
    }
    grid.origin[axis] = least;
    extent[axis] = most - least;
  }
  const S side = !of_blocks() ? list_radius : dimensions_ == 2 ? S(2.83) * spacing_ : S(2) * spacing_;
  S width[3] = {side, side, side};
  width[dimensions_ - 1] = side / S(4);
  for (;;) {
    S cells = S(1);
    for (int axis = 0; axis < dimensions_; ++axis) cells = cells * (extent[axis] / width[axis] + S(1));
    if (!(cells > S(4) * S(count) + S(64))) break;
    for (S& wider : width) wider = S(2) * wider;
  }
  for (int axis = 0; axis < dimensions_; ++axis) {
    const S cells = extent[axis] / width[axis];
    grid.cells[axis] = cells > S(1) ? static_cast<int>(cells) : 1;  // 1: also where the extent overflows
    grid.period[axis] = period_[axis];
    grid.per_metre[axis] = extent[axis] > S(0) ? S(grid.cells[axis]) / extent[axis] : S(0);
  }
  return grid;
}

// Counting sort, the last axis fastest, as particles are placed; points of one cell keep their order. Each part of the
// team counts and places the points of its own range: those of an earlier part come first in every cell.
template <class S> void Neighbours<S>::sort_into_cells(const Grid& grid, Team* team) {
  const int count = static_cast<int>(order_.size()), cells = grid.cells[0] * grid.cells[1] * grid.cells[2];
  const int parts = parts_of(team, count);
  next_slot_.assign(std::size_t(parts) * cells, 0);
  over_points(count, team, [&](Share own, int part) {
    int* const found = &next_slot_[std::size_t(part) * cells];
    for (int i = own.first; i < own.last; ++i) {
      int cell = 0;
      for (int axis = 0; axis < dimensions_; ++axis) {
        const S at = (wrapped_[std::size_t(i) * dimensions_ + axis] - grid.origin[axis]) * grid.per_metre[axis];
        const int last = grid.cells[axis] - 1;
        cell = cell * grid.cells[axis] + (at < S(last) ? (at > S(0) ? static_cast<int>(at) : 0) : last);
      }
      cell_of_[i] = cell;
      ++found[cell];
    }
  });
  cell_begin_.resize(cells + 1);
  int slot = 0;
  for (int cell = 0; cell < cells; ++cell) {
    cell_begin_[cell] = slot;
    for (int part = 0; part < parts; ++part) {
      int& next = next_slot_[std::size_t(part) * cells + cell];
      slot += std::exchange(next, slot);
    }
  }
  cell_begin_[cells] = slot;
  over_points(count, team, [&](Share own, int part) {
    int* const next = &next_slot_[std::size_t(part) * cells];
    for (int i = own.first; i < own.last; ++i) {
      const int to = next[cell_of_[i]]++;
      slot_of_[i] = to;
      order_[to] = i;
      for (int axis = 0; axis < dimensions_; ++axis)
        sorted_[axis * stride() + to] = wrapped_[std::size_t(i) * dimensions_ + axis];
    }
  });
  for (int axis = 0; axis < dimensions_; ++axis)
    std::fill_n(&sorted_[axis * stride() + count], kLaneCount, sorted_[axis * stride() + count - 1]);
}

// The cells of an axis that come within `list_radius` of x: `count` of them from `first` on, an index that continues
// beyond the period. All cells of the period, where there are not more: then some may be within it on both sides.
template <class S> ATWOOD_INLINE auto Neighbours<S>::Grid::band(S x, S list_radius, int axis) const -> Band {
  const int count = cells[axis];
  const S low = (x - list_radius - origin[axis]) * per_metre[axis],
          high = (x + list_radius - origin[axis]) * per_metre[axis];
  if (period[axis] == S(0)) {
    const int from = low > S(0) ? std::min(static_cast<int>(low), count - 1) : 0;
    const int to = high < S(count) ? std::max(static_cast<int>(high), 0) : count - 1;
    return {from, to - from + 1, false};
  }
  const int from = static_cast<int>(low + S(count)) - count, to = static_cast<int>(high);  // low > -count, high > 0
  if (to - from >= count - 1) return {0, count, true};
  return {from, to - from + 1, false};
}

// Distance from x to a cell, along an axis.
template <class S> ATWOOD_INLINE S Neighbours<S>::Grid::distance(S x, int cell, int axis) const {
  const S at = (x - origin[axis]) * per_metre[axis] - S(cell);
  const S apart = at < S(0) ? -at : at > S(1) ? at - S(1) : S(0);
  return apart == S(0) ? S(0) : apart / per_metre[axis];
}

// The lists of slots [first_slot, last_slot). The points are taken in their order and entered into the lists of all
// their neighbours, so that each list is in ascending order of the points without being sorted.
template <class S> bool Neighbours<S>::fill_lists(const Grid& grid, int first_slot, int last_slot) {
  if (first_slot >= last_slot) return true;
  const int first = first_slot / kLaneCount, last = whole_blocks(last_slot);
  if (of_blocks()) std::fill(block_longest_.begin() + first, block_longest_.begin() + last, 0);
  else std::fill(counts_.begin() + first * kLaneCount, counts_.begin() + last * kLaneCount, 0);
  bool fits = true;
  const auto fill = [&](auto d, auto blocks) ATWOOD_INLINED {
    fits = fill_lists<decltype(d)::value, decltype(blocks)::value>(grid, first_slot, last_slot);
  };
  in_lanes<S>(widest_vectors(), [&](auto) ATWOOD_INLINED {
    using Two = std::integral_constant<int, 2>;
    using Three = std::integral_constant<int, 3>;
    if (of_blocks()) dimensions_ == 2 ? fill(Two{}, std::true_type{}) : fill(Three{}, std::true_type{});
    else dimensions_ == 2 ? fill(Two{}, std::false_type{}) : fill(Three{}, std::false_type{});
  });
  return fits;
}

template <class S>
template <int d, bool blocks>
ATWOOD_INLINE bool Neighbours<S>::fill_lists(const Grid& grid, int first_slot, int last_slot) {
  const int count = static_cast<int>(order_.size());
  std::vector<int> near(count + 1);  // slots, or blocks, within the list radius of a point
  const SlotRanges around = slots_around(grid, first_slot, last_slot);
  for (int j = 0; j < count; ++j) {
    const int own = slot_of_[j];
    if (!around.hold(own)) continue;
    const int found = find_near<d, blocks>(grid, j, first_slot, last_slot, near.data());
    for (int n = 0; n < found; ++n) {
      const int k = near[n], lane = k % kLaneCount;
      int& entered = blocks ? block_longest_[k] : counts_[k];
      if (entered == capacity_) return false;
      if constexpr (blocks) {
        int* const list = &entries_[std::size_t(k) * capacity_];
        const bool again = entered > 0 && list[entered - 1] == own;  // a block that was near in two rows
        list[entered] = own;
        entered += again ? 0 : 1;
      } else {
        entries_[std::size_t(k - lane) * capacity_ + std::size_t(entered) * kLaneCount + lane] = own;
        entered += k != own ? 1 : 0;
      }
    }
  }
  return true;
}

// Slots that hold all points within the list radius of those of [first_slot, last_slot): those of the same sheets of
// cells across axis 0, and of the sheets beside that the list radius reaches, with one more for round-off.
template <class S>
auto Neighbours<S>::slots_around(const Grid& grid, int first_slot, int last_slot) const -> SlotRanges {
  const int sheets = grid.cells[0], sheet_size = grid.cells[1] * grid.cells[2], count = static_cast<int>(order_.size());
  const auto sheet_of = [&](int slot) { return cell_of_[order_[slot]] / sheet_size; };
  const int reach = static_cast<int>(real::min((support_ + skin_) * grid.per_metre[0], S(sheets))) + 2;
  const int low = sheet_of(first_slot) - reach, high = sheet_of(last_slot - 1) + reach + 1;
  const auto begin_of = [&](int sheet) { return cell_begin_[std::clamp(sheet, 0, sheets) * sheet_size]; };
  SlotRanges around{begin_of(low), begin_of(high), 0, count};
  if (grid.period[0] == S(0)) return around;
  around.end_of_low = begin_of(high - sheets);
  around.begin_of_high = begin_of(low + sheets);
  return around;
}

// The slots of [first_slot, last_slot), or the blocks of them, within the list radius of point j, itself included;
// returns how many. A block may be found several times, one after the other.
template <class S>
template <int d, bool blocks>
ATWOOD_INLINE int Neighbours<S>::find_near(const Grid& grid, int j, int first_slot, int last_slot, int* near) const {
  constexpr int along = d - 1, across = d - 2;  // the rows; axis 0 of three stacks them in layers
  const S *const x = &wrapped_[std::size_t(j) * d], list_radius = support_ + skin_;
  const int rows = grid.cells[across], length = grid.cells[along];
  const Band near_layers = d == 3 ? grid.band(x[0], list_radius, 0) : Band{0, 1, false};
  const Band near_rows = grid.band(x[across], list_radius, across);
  int found = 0;
  S image[3];  // of the point, where the cells are near to
  for (int u = near_layers.first; u < near_layers.first + near_layers.count; ++u) {
    const int layer = d == 3 ? grid.within(u, 0) * rows * length : 0;
    if (cell_begin_[layer] >= last_slot || cell_begin_[layer + rows * length] <= first_slot) continue;
    if (d == 3) image[0] = x[0] - grid.shift(u, 0);
    const S apart = d == 2 || near_layers.whole_period ? S(0) : grid.distance(x[0], u, 0);
    for (int v = near_rows.first; v < near_rows.first + near_rows.count; ++v) {
      const int row = layer + grid.within(v, across) * length;
      if (cell_begin_[row] >= last_slot || cell_begin_[row + length] <= first_slot) continue;
      image[across] = x[across] - grid.shift(v, across);
      const S aside = near_rows.whole_period ? S(0) : grid.distance(x[across], v, across);
      const S left2 = list_radius * list_radius - apart * apart - aside * aside;
      if (left2 < S(0)) continue;
      const Band cells = grid.band(x[along], real::sqrt(left2), along);
      const bool any_image = cells.whole_period || near_rows.whole_period || near_layers.whole_period;
      // Neighbouring cells of a row are neighbours in memory, except across the period.
      for (int w = cells.first, end = cells.first + cells.count; w < end;) {
        const int first = grid.within(w, along), run = std::min(end - w, length - first);
        image[along] = x[along] - grid.shift(w, along);
        w += run;
        const int low = std::max(cell_begin_[row + first], first_slot);
        const int high = std::min(cell_begin_[row + first + run], last_slot);
        if constexpr (blocks)
          found = any_image ? append_near_blocks<d, true>(x, low, high, near, found)
                            : append_near_blocks<d, false>(image, low, high, near, found);
        else
          found = any_image ? append_near<d, true>(x, low, high, near, found)
                            : append_near<d, false>(image, low, high, near, found);
      }
    }
  }
  return found;
}

// The squared distances from x to the slots from `slot` on.
template <class S>
template <int d, bool nearest>
ATWOOD_INLINE void Neighbours<S>::distances2(const S* x, int slot, S (&r2)[kLaneCount]) const {
  for (int k = 0; k < kLaneCount; ++k) r2[k] = S(0);
  for (int c = 0; c < d; ++c) {
    const S* const at = sorted_.data() + c * stride() + slot;
    for (int k = 0; k < kLaneCount; ++k) {
      S apart = at[k] - x[c];
      if (nearest && period_[c] > S(0)) {
        apart = real::abs(apart);
        apart = real::min(apart, period_[c] - apart);
      }
      r2[k] += apart * apart;
    }
  }
}

// Appends the slots of [begin, end) within the list radius of x, after the `found` first ones; returns how many there
// are then.
template <class S>
template <int d, bool nearest>
ATWOOD_INLINE int Neighbours<S>::append_near(const S* x, int begin, int end, int* near, int found) const {
  const S reach2 = (support_ + skin_) * (support_ + skin_);
  for (; begin < end; begin += kLaneCount) {
    S r2[kLaneCount];
    distances2<d, nearest>(x, begin, r2);
    for (int k = 0; k < std::min(kLaneCount, end - begin); ++k) {
      near[found] = begin + k;
      found += r2[k] <= reach2 ? 1 : 0;
    }
  }
  return found;
}

// The same of the blocks with slots of [begin, end).
template <class S>
template <int d, bool nearest>
ATWOOD_INLINE int Neighbours<S>::append_near_blocks(const S* x, int begin, int end, int* near, int found) const {
  const S reach2 = (support_ + skin_) * (support_ + skin_);
  for (int block = begin / kLaneCount, last = begin < end ? whole_blocks(end) : block; block < last; ++block) {
    S r2[kLaneCount];
    distances2<d, nearest>(x, block * kLaneCount, r2);
    for (int half = kLaneCount / 2; half > 0; half /= 2)
      for (int k = 0; k < half; ++k) r2[k] = r2[k + half] < r2[k] ? r2[k + half] : r2[k];
    near[found] = block;
    found += r2[0] <= reach2 ? 1 : 0;
  }
  return found;
}

// Fills the lists of a block's slots up to the longest with the lane's own slot.
template <class S> void Neighbours<S>::fill_up(int b) {
  const int first = b * kLaneCount, last_slot = static_cast<int>(order_.size()) - 1;
  int* const entries = &entries_[std::size_t(first) * capacity_];
  block_longest_[b] = *std::max_element(&counts_[first], &counts_[first] + kLaneCount);
  for (int lane = 0; lane < kLaneCount; ++lane)
    for (int n = counts_[first + lane]; n < block_longest_[b]; ++n)
      entries[n * kLaneCount + lane] = std::min(first + lane, last_slot);
}

// Fills up the lists, and finds along which axes the pairs of a block may wrap.
template <class S> void Neighbours<S>::finish_blocks(int first_block, int last_block) {
  const int count = static_cast<int>(order_.size());
  const S margin = support_ + S(2) * skin_;
  for (int b = first_block; b < last_block; ++b) {
    const int first = b * kLaneCount;
    if (!of_blocks()) fill_up(b);
    unsigned wraps = 0;
    for (int lane = 0; lane < kLaneCount; ++lane) {
      const int slot = std::min(first + lane, count - 1);
      for (int axis = 0; axis < dimensions_; ++axis) {
        const S at = sorted_[axis * stride() + slot];
        if (period_[axis] > S(0) && !(at > margin && at < period_[axis] - margin)) wraps |= 1u << axis;
      }
    }
    block_wraps_[b] = static_cast<unsigned char>(wraps);
  }
}

template class Neighbours<float>;
template class Neighbours<double>;
template class Neighbours<long double>;
template class Neighbours<Quad>;

}  // namespace atwood::fluid
