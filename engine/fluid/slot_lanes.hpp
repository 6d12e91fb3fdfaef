// How the sums over pairs read their numbers: a lane, or as many lanes of a block as a register holds (sums.cpp,
// transport.cpp).
#pragma once

#include "fluid/neighbours.hpp"
#include "fluid/registers.hpp"
#include "fluid/sums.hpp"

namespace atwood::fluid {

// A lane, or lanes of a block: how they read their own numbers, from where those of the block begin. The numbers of a
// neighbour are the same for all.
template <class S> struct OneLane {
  using Value = S;
  int lane;
  ATWOOD_INLINE S own(const S* block, int stride) const { return block[lane * stride]; }
  ATWOOD_INLINE S root_of(S a) const { return real::sqrt(a); }
  // Whether no lane has a neighbour at this distance within its support.
  ATWOOD_INLINE bool all_beyond(const Kernel<S>& kernel, S r2) const { return beyond_support(kernel, r2); }
  ATWOOD_INLINE S other_than(int neighbour) const { return neighbour == lane ? S(0) : S(1); }
  ATWOOD_INLINE void write(S value, S* block, int stride) const { block[lane * stride] = value; }
};
// The lanes from `first` on, as many as a register of the machine holds.
template <class S, VectorWidth width> struct RegisterLanes {
  using Value = Register<S, width>;
  static constexpr int count = sizeof(Value) / sizeof(S);
  int first;
  template <class Of> ATWOOD_INLINE static Value each(const Of& of) {
    if constexpr (count == 4) return Value{of(0), of(1), of(2), of(3)};
    else return Value{of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)};
  }
  ATWOOD_INLINE Value own(const S* block, int stride) const {
    return each([&](int k) ATWOOD_INLINED { return block[(first + k) * stride]; });
  }
  ATWOOD_INLINE Value root_of(const Value& a) const { return root(WholePack<width>{}, a); }
  ATWOOD_INLINE bool all_beyond(const Kernel<S>&, const Value&) const { return false; }  // asking takes as long
  ATWOOD_INLINE Value other_than(int neighbour) const {
    return each([&](int k) ATWOOD_INLINED { return first + k == neighbour ? S(0) : S(1); });
  }
  ATWOOD_INLINE void write(const Value& value, S* block, int stride) const {
    for (int k = 0; k < count; ++k) block[(first + k) * stride] = value[k];
  }
};

template <class S, class Lanes>
ATWOOD_INLINE void read_own_records(const Lanes& lanes, const S* block, typename Lanes::Value (&own)[kRecordSize]) {
  for (int f = 0; f < kRecordSize; ++f) own[f] = lanes.own(block + f, kRecordSize);
}

// Differences of coordinates by the nearest image, along the axes whose period the pairs of a block may lie across.
template <int d, class V> struct NearestImages {
  unsigned wrapping;
  V half[d], whole[d];
  template <class S> ATWOOD_INLINE NearestImages(const Neighbours<S>& lists, unsigned axes) : wrapping(axes) {
    for (int c = 0; c < d; ++c) half[c] = V{} + S(0.5) * lists.period(c), whole[c] = V{} + lists.period(c);
  }
  ATWOOD_INLINE V operator()(const V& difference, int c) const {
    return (wrapping >> c & 1) == 0 ? difference : nearest_image(difference, half[c], whole[c]);
  }
};

inline constexpr int kPassed = 16;  // neighbours that go from the first pass to the second at a time

// each(j, x_ij, of(shape, s), record of j) for the neighbours j of a block, in their order; s = r / support, `own`
// begins with the position, and `of` is an exact 0 beyond the support. In two passes over some neighbours at a time:
// the long latency of a root then delays no sum.
template <int d, class S, class Lanes, class Of, class Each>
ATWOOD_INLINE void over_pairs(const Neighbours<S>& lists, const NeighbourBlock& block, const Kernel<S>& kernel,
                              const S* records, const Lanes& lanes, const typename Lanes::Value* own, const Of& of,
                              const Each& each) {
  using V = typename Lanes::Value;
  const NearestImages<d, V> nearest(lists, block.wraps);
  const auto differences = [&](const S* other, V(&x)[d]) ATWOOD_INLINED {
    for (int c = 0; c < d; ++c) x[c] = nearest(V(own[c] - other[c]), c);
  };
  std::ptrdiff_t near[kPassed];
  V values[kPassed];
  for (int first = 0; first < block.longest; first += kPassed) {
    const int last = first + kPassed < block.longest ? first + kPassed : block.longest;
    int count = 0;
    of_shape(kernel.shape, [&](auto shape) ATWOOD_INLINED {
      for (int n = first; n < last; ++n) {
        V x[d];
        near[count] = block.entries[n];
        differences(records + near[count] * kRecordSize, x);
        V r2 = x[0] * x[0];
        for (int c = 1; c < d; ++c) r2 = r2 + x[c] * x[c];
        if (lanes.all_beyond(kernel, r2)) continue;
        values[count++] = of(shape, V(lanes.root_of(r2) * kernel.inverse_support));
      }
    });
    for (int n = 0; n < count; ++n) {
      const S* const other = records + near[n] * kRecordSize;
      V x[d];
      differences(other, x);
      each(near[n], x, values[n], other);
    }
  }
}

// block_of(lanes) for all lanes of a block: a register at a time, or lane after lane.
template <class S, VectorWidth width, class BlockOf>
ATWOOD_INLINE void over_lanes(bool lane_by_lane, const BlockOf& block_of) {
  if constexpr (has_vector_lanes<S>) {
    if (!lane_by_lane) {
      using Lanes = RegisterLanes<S, width>;
      for (int k = 0; k < kLaneCount; k += Lanes::count) block_of(Lanes{k});
      return;
    }
  }
  for (int k = 0; k < kLaneCount; ++k) block_of(OneLane<S>{k});
}

}  // namespace atwood::fluid
