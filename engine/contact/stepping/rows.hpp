// Rows and lanes: a row holds eight scalars of one body in one cache line; a pack holds one scalar of eight bodies or
// contacts. gather() transposes eight rows into eight packs: lane k of pack c is entry c of row k. scatter() is its
// inverse.
#pragma once

#include <cstdint>

#include "math/pack.hpp"

namespace atwood::stepping {

template <class S> struct alignas(kLaneCount * sizeof(S)) Row { S at[kLaneCount]; };

// One scalar of eight contacts, in memory.
template <class S> using Lanes = LaneBlock<S>;

template <class S> ATWOOD_INLINE Vec3<Pack<S>> load_lanes(const Lanes<S> (&from)[3]) {
  return {load(from[0].lane), load(from[1].lane), load(from[2].lane)};
}
template <class S> ATWOOD_INLINE void store_lanes(const Vec3<Pack<S>>& a, Lanes<S> (&to)[3]) {
  store<S>(a.x, to[0].lane);
  store<S>(a.y, to[1].lane);
  store<S>(a.z, to[2].lane);
}

// Without registers of 512 bits GCC compiles comparisons and shuffles of packs of doubles lane by lane. Of halves it
// makes AVX2 instructions.
template <class S, VectorWidth width>
inline constexpr bool kByHalves = sizeof(Pack<S>) == 64 && width == VectorWidth::v3;
using HalfPack = double __attribute__((vector_size(32)));
struct Halves {
  HalfPack low, high;
};
ATWOOD_INLINE Halves halves_of(const DoublePack& a) {
  Halves out;
  __builtin_memcpy(&out, &a, sizeof(a));
  return out;
}
ATWOOD_INLINE DoublePack whole_of(const Halves& a) {
  DoublePack out;
  __builtin_memcpy(&out, &a, sizeof(a));
  return out;
}

// x where a > b; y elsewhere, and where a or b is NaN.
template <class S, VectorWidth width>
ATWOOD_INLINE Pack<S> where_above(const Pack<S>& a, const Pack<S>& b, const Pack<S>& x, const Pack<S>& y) {
  if constexpr (kByHalves<S, width>) {
    const Halves ha = halves_of(a), hb = halves_of(b), hx = halves_of(x), hy = halves_of(y);
    return whole_of({ha.low > hb.low ? hx.low : hy.low, ha.high > hb.high ? hx.high : hy.high});
  } else {
    return a > b ? x : y;
  }
}

// Transposes four rows of four, in place.
ATWOOD_INLINE void transpose4(HalfPack& a, HalfPack& b, HalfPack& c, HalfPack& d) {
  const HalfPack ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6),
                 ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const HalfPack cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6),
                 cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5);
  c = __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7);
  d = __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7);
}

// Numbers the lanes of a and b from 0 to 15. Sets a to the lanes `low`, b to the lanes `low` + `far`.
template <int far, int... low, class P> ATWOOD_INLINE void exchange(P& a, P& b) {
  const P before = a;
  a = __builtin_shufflevector(before, b, low...);
  b = __builtin_shufflevector(before, b, (low + far)...);
}

// Transposes eight rows, in place. Stage k exchanges bit k of the row's number with bit k of the lane's; halves are
// transposed quarter by quarter.
template <class S, VectorWidth width> ATWOOD_INLINE void transpose(Pack<S> (&r)[kLaneCount]) {
  if constexpr (kByHalves<S, width>) {
    Halves h[kLaneCount];
#pragma GCC unroll 8
    for (int i = 0; i < kLaneCount; ++i) h[i] = halves_of(r[i]);
    transpose4(h[0].low, h[1].low, h[2].low, h[3].low);
    transpose4(h[4].low, h[5].low, h[6].low, h[7].low);
    transpose4(h[0].high, h[1].high, h[2].high, h[3].high);
    transpose4(h[4].high, h[5].high, h[6].high, h[7].high);
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) {
      r[i] = whole_of({h[i].low, h[i + 4].low});
      r[i + 4] = whole_of({h[i].high, h[i + 4].high});
    }
    return;
  }
#pragma GCC unroll 4
  for (const int i : {0, 2, 4, 6}) exchange<1, 0, 8, 2, 10, 4, 12, 6, 14>(r[i], r[i + 1]);
#pragma GCC unroll 4
  for (const int i : {0, 1, 4, 5}) exchange<2, 0, 1, 8, 9, 4, 5, 12, 13>(r[i], r[i + 2]);
#pragma GCC unroll 4
  for (const int i : {0, 1, 2, 3}) exchange<4, 0, 1, 2, 3, 8, 9, 10, 11>(r[i], r[i + 4]);
}

template <class S, VectorWidth width>
ATWOOD_INLINE void gather(const Row<S>* rows, const std::int32_t (&index)[kLaneCount], Pack<S> (&out)[kLaneCount]) {
#pragma GCC unroll 8
  for (int k = 0; k < kLaneCount; ++k) out[k] = load(rows[index[k]].at);
  transpose<S, width>(out);
}
// Writes the first `count` lanes; their indices are distinct.
template <class S, VectorWidth width>
ATWOOD_INLINE void scatter(Pack<S> (&in)[kLaneCount], const std::int32_t (&index)[kLaneCount], int count,
                           Row<S>* rows) {
  transpose<S, width>(in);
  if (count == kLaneCount) {
#pragma GCC unroll 8
    for (int k = 0; k < kLaneCount; ++k) store<S>(in[k], rows[index[k]].at);
  } else {
#pragma GCC unroll 8
    for (int k = 0; k < kLaneCount; ++k)
      if (k < count) store<S>(in[k], rows[index[k]].at);
  }
}

template <class S, VectorWidth width> ATWOOD_INLINE bool any_above_zero(const Pack<S>& a) {
  const Pack<S> found = where_above<S, width>(a, broadcast(S(0)), broadcast(S(1)), broadcast(S(0)));
  if constexpr (kByHalves<S, width>) {
    const Halves halves = halves_of(found);
    const HalfPack sum = halves.low + halves.high;
    return (sum[0] + sum[2]) + (sum[1] + sum[3]) > S(0);
  }
  const S evens = (found[0] + found[4]) + (found[2] + found[6]), odds = (found[1] + found[5]) + (found[3] + found[7]);
  return evens + odds > S(0);
}

template <class S, VectorWidth width> ATWOOD_INLINE Pack<S> min(const Pack<S>& a, const Pack<S>& b) {
  return where_above<S, width>(b, a, a, b);
}
template <class S, VectorWidth width> ATWOOD_INLINE Pack<S> max(const Pack<S>& a, const Pack<S>& b) {
  return where_above<S, width>(a, b, a, b);
}

// Entries 0 to 2 of gathered rows: velocities, positions. Entries 3 to 5: body rates, rotation vectors.
template <class S> ATWOOD_INLINE Vec3<Pack<S>> linear_part(const Pack<S> (&row)[kLaneCount]) {
  return {row[0], row[1], row[2]};
}
template <class S> ATWOOD_INLINE Vec3<Pack<S>> angular_part(const Pack<S> (&row)[kLaneCount]) {
  return {row[3], row[4], row[5]};
}
template <class S> ATWOOD_INLINE void store_vector(const Vec3<Pack<S>>& a, Pack<S>* entries) {
  entries[0] = a.x;
  entries[1] = a.y;
  entries[2] = a.z;
}
template <class S> ATWOOD_INLINE void set_zero(Pack<S> (&row)[kLaneCount]) {
  for (auto& entry : row) entry = broadcast(S(0));
}

}  // namespace atwood::stepping
