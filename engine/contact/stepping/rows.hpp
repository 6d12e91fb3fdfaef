// Eight scalars of a body in one cache line, and eight bodies' rows turned into packs: lane k of pack c is row k's entry c.
#pragma once

#include <cstdint>

#include "math/pack.hpp"

namespace atwood::stepping {

template <class S> struct alignas(lane_count * sizeof(S)) Row { S at[lane_count]; };

// Eight vectors of a number, a contact a lane.
template <class S> using Lanes = LaneBlock<S>;

template <class S> ATWOOD_INLINE Vec3<Pack<S>> load_lanes(const Lanes<S> (&from)[3]) {
  return {load(from[0].lane), load(from[1].lane), load(from[2].lane)};
}
template <class S> ATWOOD_INLINE void store_lanes(const Vec3<Pack<S>>& a, Lanes<S> (&to)[3]) {
  store<S>(a.x, to[0].lane);
  store<S>(a.y, to[1].lane);
  store<S>(a.z, to[2].lane);
}

// In place. Stage by stage, bit k of the row's number changes places with bit k of the lane's.
template <class S> ATWOOD_INLINE void transpose(Pack<S> (&r)[lane_count]) {
  using I = decltype(r[0] < r[0]);
  constexpr I low[3] = {{0, 8, 2, 10, 4, 12, 6, 14}, {0, 1, 8, 9, 4, 5, 12, 13}, {0, 1, 2, 3, 8, 9, 10, 11}};
  constexpr I high[3] = {{1, 9, 3, 11, 5, 13, 7, 15}, {2, 3, 10, 11, 6, 7, 14, 15}, {4, 5, 6, 7, 12, 13, 14, 15}};
#pragma GCC unroll 3
  for (int stage = 0; stage < 3; ++stage) {
    const int far = 1 << stage;
#pragma GCC unroll 8
    for (int i = 0; i < lane_count; ++i) {
      if (i & far) continue;
      const Pack<S> a = r[i], b = r[i + far];
      r[i] = __builtin_shuffle(a, b, low[stage]);
      r[i + far] = __builtin_shuffle(a, b, high[stage]);
    }
  }
}

template <class S> ATWOOD_INLINE void gather(const Row<S>* rows, const std::int32_t (&index)[lane_count], Pack<S> (&out)[lane_count]) {
#pragma GCC unroll 8
  for (int k = 0; k < lane_count; ++k) out[k] = load(rows[index[k]].at);
  transpose<S>(out);
}
// The first `count` lanes; their rows are different ones.
template <class S>
ATWOOD_INLINE void scatter(Pack<S> (&in)[lane_count], const std::int32_t (&index)[lane_count], int count, Row<S>* rows) {
  transpose<S>(in);
  if (count == lane_count) {
#pragma GCC unroll 8
    for (int k = 0; k < lane_count; ++k) store<S>(in[k], rows[index[k]].at);
  } else {
#pragma GCC unroll 8
    for (int k = 0; k < lane_count; ++k)
      if (k < count) store<S>(in[k], rows[index[k]].at);
  }
}

template <class S> ATWOOD_INLINE bool any_above_zero(const Pack<S>& a) {
  bool any = false;
#pragma GCC unroll 8
  for (int k = 0; k < lane_count; ++k) any |= a[k] > S(0);
  return any;
}

}  // namespace atwood::stepping
