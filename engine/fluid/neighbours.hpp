// The pairs of points that may lie within the support of a kernel, from cell lists, with a Verlet skin.
//
// A list holds all points within support + skin; it is built again once two points may have come within the support
// unseen, that is once some point has moved by skin / 2. What a caller sums over a list does not depend on when it was
// built: each list is in ascending order of the points, and its members beyond the support contribute exact zeros.
//
// Points are kept in memory in the order of their cells: slot k is point order()[k]. Slots stand in blocks of
// kLaneCount, one a vector lane (math/lanes.hpp), and are padded to whole blocks; the padding stands for the last
// point. Lists are of one of two kinds; their entries are slots.
//
//   of slots    entry n of lane k at entries[n * kLaneCount + k]. Lists shorter than the block's longest are filled up
//               with the lane's own slot; those of the padding are empty. Each lane reads its own neighbour: fewest
//               pairs, for sums that cost much a pair.
//   of blocks   entry n at entries[n], near some point of the block; the block's own points are among them. All lanes
//               take the same neighbour, broadcast instead of gathered: some 1.7 times the pairs at a third of the time
//               each, and lists of a fifth of the length. Cells are small, so that the points of a block lie close
//               together.
//
// Sources: Verlet (1967); Hockney and Eastwood, Computer Simulation Using Particles (1988), 8-4.
#pragma once

#include <cstdint>
#include <vector>

#include "math/lanes.hpp"
#include "parallel/team.hpp"
#include "scene/fluid.hpp"

namespace atwood::fluid {

struct NeighbourBlock {
  const int* entries;  // `longest` rows of kLaneCount slots; of blocks: `longest` slots
  int longest;
  const int* counts;  // of the block's lanes, without the filling; of blocks: null
  unsigned wraps;     // bit c: some pair may lie across the period of axis c; take the nearest image
};

template <class S> class Neighbours {
 public:
  // support, skin > 0. A period must be at least twice the support, so that each pair has one image within it.
  Neighbours(const Domain& domain, S support, S skin);             // lists of slots
  Neighbours(const Domain& domain, S support, S skin, S spacing);  // lists of blocks, of points about that far apart

  // Brings the lists up to date with the points at x (`dimensions` numbers a point, unwrapped). False: some position is
  // not finite; the lists are as they were. Allocates only when built, and when counts grow.
  bool update(const S* x, int count, Team* team);
  void forget() { built_count_ = -1; }  // the next update builds

  int count() const { return static_cast<int>(order_.size()); }
  int blocks() const { return static_cast<int>(block_wraps_.size()); }
  const std::vector<int>& order() const { return order_; }      // slot -> point
  const std::vector<int>& slot_of() const { return slot_of_; }  // point -> slot
  NeighbourBlock block(int b) const {
    const int* const entries = entries_.data() + std::size_t(b) * lists_a_block() * capacity_;
    const int* const counts = of_blocks() ? nullptr : counts_.data() + std::size_t(b) * kLaneCount;
    return {entries, block_longest_[b], counts, block_wraps_[b]};
  }
  std::int64_t builds() const { return builds_; }

  // x moved by whole periods into [0, period]; unchanged along open axes.
  ATWOOD_INLINE S wrapped(S x, int axis) const {
    if (period_[axis] == S(0) || (x >= S(0) && x < period_[axis])) return x;
    return x - period_[axis] * real::floor(x * inverse_period_[axis]);
  }
  S period(int axis) const { return period_[axis]; }  // 0: open

 private:
  struct Band {
    int first, count;
    bool whole_period;
  };
  struct Grid {
    int cells[3] = {1, 1, 1};
    S origin[3]{}, per_metre[3]{}, period[3]{};
    Band band(S x, S list_radius, int axis) const;
    S distance(S x, int cell, int axis) const;
    // A cell of a band: its index in the period, and where the period that holds it begins.
    int within(int cell, int axis) const {
      return cell < 0 ? cell + cells[axis] : cell >= cells[axis] ? cell - cells[axis] : cell;
    }
    S shift(int cell, int axis) const { return cell < 0 ? -period[axis] : cell >= cells[axis] ? period[axis] : S(0); }
  };
  struct SlotRanges {  // first .. last - 1, 0 .. end_of_low - 1 and from begin_of_high on (across a period)
    int first, last, end_of_low, begin_of_high;
    bool hold(int slot) const { return (slot >= first && slot < last) || slot < end_of_low || slot >= begin_of_high; }
  };
  template <class Work> static void over_points(int count, Team* team, const Work& work);
  void build(const S* x, int count, Team* team);
  Grid make_grid() const;
  void sort_into_cells(const Grid& grid, Team* team);
  SlotRanges slots_around(const Grid& grid, int first_slot, int last_slot) const;
  bool fill_lists(const Grid& grid, int first_slot, int last_slot);  // false: a list exceeds capacity_
  void fill_up(int block);
  void finish_blocks(int first_block, int last_block);
  template <int d, bool blocks> bool fill_lists(const Grid& grid, int first_slot, int last_slot);
  template <int d, bool blocks> int find_near(const Grid& grid, int j, int first_slot, int last_slot, int* near) const;
  template <int d, bool nearest> int append_near(const S* x, int begin, int end, int* near, int found) const;
  template <int d, bool nearest> int append_near_blocks(const S* x, int begin, int end, int* near, int found) const;
  template <int d, bool nearest> ATWOOD_INLINE void distances2(const S* x, int slot, S (&r2)[kLaneCount]) const;
  bool of_blocks() const { return spacing_ > S(0); }
  int lists_a_block() const { return of_blocks() ? 1 : kLaneCount; }
  std::size_t stride() const { return order_.size() + kLaneCount; }  // of sorted_, read by whole registers

  int dimensions_;
  S period_[3]{}, inverse_period_[3]{}, support_, skin_, spacing_{};
  std::int64_t builds_ = 0;
  int built_count_ = -1, capacity_ = 2 * kLaneCount;
  std::vector<S> built_at_, wrapped_, sorted_;  // positions at the build; wrapped, by point and by slot
  std::vector<int> order_, slot_of_, cell_of_, cell_begin_, next_slot_, counts_, block_longest_, entries_;
  std::vector<unsigned char> block_wraps_;
};

// The nearest image of a difference of wrapped coordinates, for scalars and packs; antisymmetric to the last bit.
template <class V> ATWOOD_INLINE V nearest_image(const V& difference, const V& half, const V& whole) {
  const V down = difference > half ? whole : V{}, up = difference < -half ? whole : V{};
  return difference - down + up;
}
template <class S, class V> ATWOOD_INLINE V nearest_image(const V& difference, S period) {
  return nearest_image(difference, V(V{} + S(0.5) * period), V(V{} + period));
}

}  // namespace atwood::fluid
