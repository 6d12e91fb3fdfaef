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

template <class S, VectorWidth width> ATWOOD_INLINE Vec3<PackAt<S, width>> load_lanes(const Lanes<S> (&from)[3]) {
  return {load_at<width>(from[0].lane), load_at<width>(from[1].lane), load_at<width>(from[2].lane)};
}
template <class S, class P> ATWOOD_INLINE void store_lanes(const Vec3<P>& a, Lanes<S> (&to)[3]) {
  store<S>(a.x, to[0].lane);
  store<S>(a.y, to[1].lane);
  store<S>(a.z, to[2].lane);
}

// Transposes four rows of four, in place.
ATWOOD_INLINE void transpose4(FourDoubles& a, FourDoubles& b, FourDoubles& c, FourDoubles& d) {
  const FourDoubles ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6),
                    ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const FourDoubles cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6),
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
template <class P> ATWOOD_INLINE void transpose(P (&r)[kLaneCount]) {
#pragma GCC unroll 4
  for (const int i : {0, 2, 4, 6}) exchange<1, 0, 8, 2, 10, 4, 12, 6, 14>(r[i], r[i + 1]);
#pragma GCC unroll 4
  for (const int i : {0, 1, 4, 5}) exchange<2, 0, 1, 8, 9, 4, 5, 12, 13>(r[i], r[i + 2]);
#pragma GCC unroll 4
  for (const int i : {0, 1, 2, 3}) exchange<4, 0, 1, 2, 3, 8, 9, 10, 11>(r[i], r[i + 4]);
}
ATWOOD_INLINE void transpose(Halves<FourDoubles> (&r)[kLaneCount]) {
  transpose4(r[0].low, r[1].low, r[2].low, r[3].low);
  transpose4(r[4].low, r[5].low, r[6].low, r[7].low);
  transpose4(r[0].high, r[1].high, r[2].high, r[3].high);
  transpose4(r[4].high, r[5].high, r[6].high, r[7].high);
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {
    const FourDoubles high = r[i].high;
    r[i].high = r[i + 4].low;
    r[i + 4].low = high;
  }
}
ATWOOD_INLINE void transpose(Halves<Halves<TwoDoubles>> (&r)[kLaneCount]) {
  double rows[kLaneCount][kLaneCount], columns[kLaneCount][kLaneCount];
  for (int i = 0; i < kLaneCount; ++i) store<double>(r[i], rows[i]);
  for (int i = 0; i < kLaneCount; ++i)
    for (int k = 0; k < kLaneCount; ++k) columns[i][k] = rows[k][i];
  for (int i = 0; i < kLaneCount; ++i) r[i] = load_at<VectorWidth::narrow>(columns[i]);
}

template <class S, VectorWidth width>
ATWOOD_INLINE void gather(const Row<S>* rows, const std::int32_t (&index)[kLaneCount],
                          PackAt<S, width> (&out)[kLaneCount]) {
#pragma GCC unroll 8
  for (int k = 0; k < kLaneCount; ++k) out[k] = load_at<width>(rows[index[k]].at);
  transpose(out);
}
// Writes the first `count` lanes; their indices are distinct.
template <class S, VectorWidth width>
ATWOOD_INLINE void scatter(PackAt<S, width> (&in)[kLaneCount], const std::int32_t (&index)[kLaneCount], int count,
                           Row<S>* rows) {
  transpose(in);
  if (count == kLaneCount) {
#pragma GCC unroll 8
    for (int k = 0; k < kLaneCount; ++k) store<S>(in[k], rows[index[k]].at);
  } else {
#pragma GCC unroll 8
    for (int k = 0; k < kLaneCount; ++k)
      if (k < count) store<S>(in[k], rows[index[k]].at);
  }
}

// Of zeros and ones.
template <class P> ATWOOD_INLINE bool any_one(const P& found) {
  LaneOf<P> sum = found[0];
  for (int k = 1; k < static_cast<int>(sizeof(P) / sizeof(LaneOf<P>)); ++k) sum += found[k];
  return sum > 0;
}
template <class V> ATWOOD_INLINE bool any_one(const Halves<V>& found) { return any_one(found.low + found.high); }
template <class S, VectorWidth width> ATWOOD_INLINE bool any_above_zero(const PackAt<S, width>& a) {
  return any_one(where_above(a, broadcast_at<width>(S(0)), broadcast_at<width>(S(1)), broadcast_at<width>(S(0))));
}

template <class P> ATWOOD_INLINE P min(const P& a, const P& b) { return where_above(b, a, a, b); }
template <class P> ATWOOD_INLINE P max(const P& a, const P& b) { return where_above(a, b, a, b); }

// Entries 0 to 2 of gathered rows: velocities, positions. Entries 3 to 5: body rates, rotation vectors.
template <class P> ATWOOD_INLINE Vec3<P> linear_part(const P (&row)[kLaneCount]) { return {row[0], row[1], row[2]}; }
template <class P> ATWOOD_INLINE Vec3<P> angular_part(const P (&row)[kLaneCount]) { return {row[3], row[4], row[5]}; }
template <VectorWidth width, class P> ATWOOD_INLINE void set_zero(P (&row)[kLaneCount]) {
  for (P& entry : row) entry = broadcast_at<width>(LaneOf<P>(0));
}
template <class P> ATWOOD_INLINE void store_vector(const Vec3<P>& a, P* entries) {
  entries[0] = a.x;
  entries[1] = a.y;
  entries[2] = a.z;
}

}  // namespace atwood::stepping
