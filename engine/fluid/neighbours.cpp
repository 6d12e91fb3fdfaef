#include "fluid/neighbours.hpp"

#include <algorithm>
#include <atomic>

namespace atwood::fluid {
namespace {

constexpr int kLeastShared = 2000;  // points: below, starting the team costs more than it saves

int whole_blocks(int count) { return (count + kLaneCount - 1) / kLaneCount; }

// The cells next to `cell` along an axis of `cells`, each once: first .. first + count - 1, modulo `cells` if periodic.
struct Stencil {
  int first, count;
};
Stencil stencil(int cell, int cells, bool periodic) {
  if (periodic) return cells < 3 ? Stencil{0, cells} : Stencil{cell - 1 + cells, 3};
  const int first = std::max(cell - 1, 0);
  return {first, std::min(cell + 1, cells - 1) - first + 1};
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

template <class S> bool Neighbours<S>::update(const S* x, int count, Team* team) {
  const int scalars = dimensions_ * count;
  if (built_count_ != count) built_at_.assign(scalars, S(0));
  const S most = S(0.25) * skin_ * skin_;
  bool finite = true, stale = built_count_ != count;
  for (int i = 0; i < scalars; i += dimensions_) {
    S moved2{};
    for (int axis = 0; axis < dimensions_; ++axis) {
      const S moved = x[i + axis] - built_at_[i + axis];
      moved2 += moved * moved;
    }
    finite = finite && real::is_finite(moved2);
    stale = stale || moved2 > most;
  }
  if (!finite) return false;
  if (stale) build(x, count, team);
  return true;
}

template <class S> void Neighbours<S>::build(const S* x, int count, Team* team) {
  ++builds_;
  built_count_ = count;
  const int padded = whole_blocks(count) * kLaneCount;
  built_at_.assign(x, x + std::size_t(dimensions_) * count);
  wrapped_.resize(built_at_.size());
  for (std::size_t i = 0; i < built_at_.size(); ++i) wrapped_[i] = wrapped(x[i], static_cast<int>(i) % dimensions_);
  order_.resize(count);
  slot_of_.resize(count);
  cell_of_.resize(count);
  sorted_.resize(wrapped_.size());
  counts_.resize(padded);
  block_longest_.resize(padded / kLaneCount);
  block_wraps_.resize(padded / kLaneCount);
  const Grid grid = make_grid();
  sort_into_cells(grid);
  const int blocks = padded / kLaneCount, parts = team == nullptr || count < kLeastShared ? 1 : team->size();
  for (;;) {
    entries_.resize(std::size_t(padded) * capacity_);
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
    capacity_ += capacity_ / 2;
  }
}

// Cells as wide as the reach, or wider: no more of them than points, however far the points are apart.
template <class S> auto Neighbours<S>::make_grid() const -> Grid {
  Grid grid;
  const S reach = support_ + skin_;
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
  S width = reach;
  for (;;) {
    S cells = S(1);
    for (int axis = 0; axis < dimensions_; ++axis) cells = cells * (extent[axis] / width + S(1));
    if (cells <= S(4) * S(count) + S(64)) break;
    width = S(2) * width;
  }
  for (int axis = 0; axis < dimensions_; ++axis) {
    grid.cells[axis] = std::max(1, static_cast<int>(extent[axis] / width));
    grid.per_metre[axis] = extent[axis] > S(0) ? S(grid.cells[axis]) / extent[axis] : S(0);
  }
  return grid;
}

// Counting sort, the first axis fastest; points of one cell keep their order.
template <class S> void Neighbours<S>::sort_into_cells(const Grid& grid) {
  const int count = static_cast<int>(order_.size()), cells = grid.cells[0] * grid.cells[1] * grid.cells[2];
  cell_begin_.assign(cells + 1, 0);
  for (int i = 0; i < count; ++i) {
    int cell = 0;
    for (int axis = dimensions_; axis-- > 0;) {
      const S at = (wrapped_[std::size_t(i) * dimensions_ + axis] - grid.origin[axis]) * grid.per_metre[axis];
      cell = cell * grid.cells[axis] + std::clamp(static_cast<int>(at), 0, grid.cells[axis] - 1);
    }
    cell_of_[i] = cell;
    ++cell_begin_[cell + 1];
  }
  for (int cell = 0; cell < cells; ++cell) cell_begin_[cell + 1] += cell_begin_[cell];
  std::vector<int>& next = slot_of_;  // slots are dealt out cell by cell; cell_begin_ is restored below
  for (int i = 0; i < count; ++i) next[i] = cell_begin_[cell_of_[i]]++;
  for (int cell = cells; cell > 0; --cell) cell_begin_[cell] = cell_begin_[cell - 1];
  cell_begin_[0] = 0;
  for (int i = 0; i < count; ++i) {
    order_[slot_of_[i]] = i;
    for (int axis = 0; axis < dimensions_; ++axis)
      sorted_[std::size_t(axis) * count + slot_of_[i]] = wrapped_[std::size_t(i) * dimensions_ + axis];
  }
}

// The lists of slots [first_slot, last_slot). The points are taken in their order and entered into the lists of all
// their neighbours, so that each list is in ascending order of the points without being sorted.
template <class S> bool Neighbours<S>::fill_lists(const Grid& grid, int first_slot, int last_slot) {
  const int count = static_cast<int>(order_.size()), d = dimensions_;
  if (first_slot >= last_slot) return true;
  std::fill(counts_.begin() + first_slot, counts_.begin() + whole_blocks(last_slot) * kLaneCount, 0);
  std::vector<int> near(count);  // slots within reach of a point
  for (int j = 0; j < count; ++j) {
    const int cell = cell_of_[j], own = slot_of_[j];
    const int at[3] = {cell % grid.cells[0], cell / grid.cells[0] % grid.cells[1],
                       cell / (grid.cells[0] * grid.cells[1])};
    Stencil along[3]{{0, 1}, {0, 1}, {0, 1}};
    for (int c = 0; c < d; ++c) along[c] = stencil(at[c], grid.cells[c], period_[c] > S(0));
    int found = 0;
    for (int z = 0; z < along[2].count; ++z) {
      for (int y = 0; y < along[1].count; ++y) {
        const int row_y = (along[1].first + y) % grid.cells[1], row_z = (along[2].first + z) % grid.cells[2];
        const int row = (row_z * grid.cells[1] + row_y) * grid.cells[0];
        if (cell_begin_[row + grid.cells[0]] <= first_slot || cell_begin_[row] >= last_slot) continue;
        for (int x = 0; x < along[0].count;) {
          // Neighbouring cells of a row are neighbours in memory, except across the period.
          const int from = (along[0].first + x) % grid.cells[0];
          const int run = std::min(along[0].count - x, grid.cells[0] - from);
          x += run;
          found = find_near(&wrapped_[std::size_t(j) * d], std::max(cell_begin_[row + from], first_slot),
                            std::min(cell_begin_[row + from + run], last_slot), near.data(), found);
        }
      }
    }
    for (int n = 0; n < found; ++n) {
      const int k = near[n], lane = k % kLaneCount;
      if (k == own) continue;
      if (counts_[k] == capacity_) return false;
      entries_[std::size_t(k - lane) * capacity_ + std::size_t(counts_[k]++) * kLaneCount + lane] = own;
    }
  }
  return true;
}

// Appends the slots of [begin, end) within reach of x, after the `found` first ones; returns how many there are then.
template <class S> int Neighbours<S>::find_near(const S* x, int begin, int end, int* near, int found) const {
  const S reach2 = (support_ + skin_) * (support_ + skin_);
  const std::size_t count = order_.size();
  constexpr int kChunk = 64;
  S r2[kChunk];
  for (; begin < end; begin += kChunk) {
    const int size = std::min(kChunk, end - begin);
    std::fill_n(r2, kChunk, S(0));
    for (int axis = 0; axis < dimensions_; ++axis) {
      const S *const at = &sorted_[axis * count + begin], own = x[axis], period = period_[axis];
      if (period == S(0))
        for (int k = 0; k < size; ++k) r2[k] += (at[k] - own) * (at[k] - own);
      else
        for (int k = 0; k < size; ++k) {
          const S apart = real::abs(at[k] - own), least = real::min(apart, period - apart);
          r2[k] += least * least;
        }
    }
    for (int k = 0; k < size; ++k) {
      near[found] = begin + k;
      found += r2[k] <= reach2 ? 1 : 0;
    }
  }
  return found;
}

// Fills the lists of each block up to the longest with the lane's own slot, and finds where pairs may wrap.
template <class S> void Neighbours<S>::finish_blocks(int first_block, int last_block) {
  const int count = static_cast<int>(order_.size());
  const S margin = support_ + S(2) * skin_;
  for (int b = first_block; b < last_block; ++b) {
    const int first = b * kLaneCount;
    int* const entries = &entries_[std::size_t(first) * capacity_];
    const int longest = *std::max_element(&counts_[first], &counts_[first] + kLaneCount);
    bool wraps = false;
    for (int lane = 0; lane < kLaneCount; ++lane) {
      const int slot = std::min(first + lane, count - 1);
      for (int n = counts_[first + lane]; n < longest; ++n) entries[n * kLaneCount + lane] = slot;
      for (int axis = 0; axis < dimensions_; ++axis) {
        const S at = sorted_[std::size_t(axis) * count + slot];
        wraps = wraps || (period_[axis] > S(0) && !(at > margin && at < period_[axis] - margin));
      }
    }
    block_longest_[b] = longest;
    block_wraps_[b] = wraps;
  }
}

template class Neighbours<float>;
template class Neighbours<double>;
template class Neighbours<long double>;
template class Neighbours<Quad>;

}  // namespace atwood::fluid
