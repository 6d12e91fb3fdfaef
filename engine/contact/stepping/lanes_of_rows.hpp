// What the solvers of balls and of manifolds share: vectors out of gathered rows, and what a substep prepares with.
#pragma once

#include "contact/stepping/rows.hpp"

namespace atwood::stepping {

template <class S, VectorWidth width> ATWOOD_INLINE Pack<S> min(const Pack<S>& a, const Pack<S>& b) {
  return where_above<S, width>(b, a, a, b);
}
template <class S, VectorWidth width> ATWOOD_INLINE Pack<S> max(const Pack<S>& a, const Pack<S>& b) {
  return where_above<S, width>(a, b, a, b);
}

template <class S> ATWOOD_INLINE Vec3<Pack<S>> first3(const Pack<S> (&row)[kLaneCount]) {
  return {row[0], row[1], row[2]};
}
template <class S> ATWOOD_INLINE Vec3<Pack<S>> second3(const Pack<S> (&row)[kLaneCount]) {
  return {row[3], row[4], row[5]};
}
template <class S> ATWOOD_INLINE void put3(const Vec3<Pack<S>>& a, Pack<S>* row) {
  row[0] = a.x;
  row[1] = a.y;
  row[2] = a.z;
}
template <class S> ATWOOD_INLINE void set_zero(Pack<S> (&row)[kLaneCount]) {
  for (auto& entry : row) entry = broadcast(S(0));
}

// `shifts`: what impacts within the substep add to the places at its end (impacts.cpp); null without bounces. What
// stands apart by then is measured from the shifted places, what overlaps now from the real ones.
template <class S> struct Preparation {
  S h_s{}, correction{};  // a substep; the share of an overlap that is pushed apart
  bool push_apart = false, warm = false;
  const Row<S>* shifts = nullptr;
};

}  // namespace atwood::stepping
