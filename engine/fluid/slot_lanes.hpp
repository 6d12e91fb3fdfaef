// How the sums over pairs read their numbers: a lane, or as many lanes of a block as a register holds (sums.cpp,
// transport.cpp).
#pragma once

#include "fluid/neighbours.hpp"
#include "fluid/registers.hpp"
#include "fluid/sums.hpp"

namespace atwood::fluid {

// A lane, or all lanes of a block: how it reads numbers of the slots in a row of a list.
template <class S> struct OneLane {
  using Value = S;
  int lane;
  ATWOOD_INLINE S read(const S* at, const int* row, int stride) const {
    return at[static_cast<std::ptrdiff_t>(row[lane]) * stride];
  }
  template <int size = kRecordSize>
  ATWOOD_INLINE void read_records(const S* records, const int* row, Value* fields) const {
    for (int f = 0; f < size; ++f) fields[f] = read(records + f, row, kRecordSize);
  }
  ATWOOD_INLINE S root_of(S a) const { return real::sqrt(a); }
  ATWOOD_INLINE S active(int n, const int* counts) const { return n < counts[lane] ? S(1) : S(0); }
  ATWOOD_INLINE int longest(const int* counts) const { return counts[lane]; }
  ATWOOD_INLINE void write(S value, S* at, int stride) const { at[lane * stride] = value; }
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
  ATWOOD_INLINE Value read(const S* at, const int* row, int stride) const {
    return each([&](int k) ATWOOD_INLINED { return at[static_cast<std::ptrdiff_t>(row[first + k]) * stride]; });
  }
  // The first `size` numbers of every record, an even number; two at a time, then one from the other.
  template <int size = kRecordSize>
  ATWOOD_INLINE void read_records(const S* records, const int* row, Value* fields) const {
    const S* at[count];
    for (int k = 0; k < count; ++k) at[k] = records + static_cast<std::ptrdiff_t>(row[first + k]) * kRecordSize;
    if constexpr (std::is_same_v<S, float> || width == VectorWidth::narrow) {
      for (int f = 0; f < size; ++f) fields[f] = each([&](int k) ATWOOD_INLINED { return at[k][f]; });
    } else {
      for (int f = 0; f < size; f += 2) {
        const auto two = [&](int k) ATWOOD_INLINED { return join_pairs<width>(at[k] + f, at[k + 2] + f); };
        if constexpr (count == 4) {
          const Value a = two(0), b = two(1);
          fields[f] = __builtin_shufflevector(a, b, 0, 4, 2, 6);
          fields[f + 1] = __builtin_shufflevector(a, b, 1, 5, 3, 7);
        } else {
          const Value a = __builtin_shufflevector(two(0), two(4), 0, 1, 2, 3, 4, 5, 6, 7);
          const Value b = __builtin_shufflevector(two(1), two(5), 0, 1, 2, 3, 4, 5, 6, 7);
          fields[f] = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
          fields[f + 1] = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
        }
      }
    }
  }
  ATWOOD_INLINE Value root_of(const Value& a) const { return root(WholePack<width>{}, a); }
  ATWOOD_INLINE Value active(int n, const int* counts) const {
    return each([&](int k) ATWOOD_INLINED { return n < counts[first + k] ? S(1) : S(0); });
  }
  ATWOOD_INLINE int longest(const int* counts) const {
    int most = 0;
    for (int k = 0; k < count; ++k) most = counts[first + k] > most ? counts[first + k] : most;
    return most;
  }
  ATWOOD_INLINE void write(const Value& value, S* at, int stride) const {
    for (int k = 0; k < count; ++k) at[(first + k) * stride] = value[k];
  }
};

inline constexpr int kOwnRow[kLaneCount] = {0, 1, 2, 3, 4, 5, 6, 7};

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
