// Many numbers of a kind at once, one a vector lane. Each lane does what the scalar code does, in the same order, so a
// lane's result has the same bits at any vector width.
#pragma once

#include <cstddef>
#include <vector>

#include "math/quat.hpp"

namespace atwood {

inline constexpr int lane_count = 8;  // doubles of an AVX-512 register

// A free function over plain arrays is compiled once a vector width; the loader takes the widest that the machine has.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ATWOOD_VECTOR_WIDTHS __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define ATWOOD_VECTOR_WIDTHS
#endif

template <class S> struct alignas(lane_count * sizeof(S)) LaneBlock { S lane[lane_count]; };
template <class S> using LaneArray = std::vector<LaneBlock<S>>;  // aligned to whole registers
template <class S> S* lanes_of(LaneArray<S>& blocks) { return blocks.empty() ? nullptr : blocks.front().lane; }

// f(k) for each lane; lanes are independent of each other. A full block has a trip count that the compiler knows.
template <class F> [[gnu::always_inline]] inline void for_lanes(int count, const F& f) {
  if (count == lane_count) {
#pragma GCC ivdep
    for (int k = 0; k < lane_count; ++k) f(k);
  } else {
#pragma GCC ivdep
    for (int k = 0; k < count; ++k) f(k);
  }
}

// Component c of lane k at at[c * stride + k].
template <class S> Vec3<S> load3(const S* at, std::ptrdiff_t stride) { return {at[0], at[stride], at[2 * stride]}; }
template <class S> Quat<S> load4(const S* at, std::ptrdiff_t stride) {
  return {at[0], at[stride], at[2 * stride], at[3 * stride]};
}
template <class S> void store3(const Vec3<S>& a, S* at, std::ptrdiff_t stride) {
  at[0] = a.x;
  at[stride] = a.y;
  at[2 * stride] = a.z;
}
template <class S> void store4(const Quat<S>& q, S* at, std::ptrdiff_t stride) {
  at[0] = q.w;
  at[stride] = q.x;
  at[2 * stride] = q.y;
  at[3 * stride] = q.z;
}

}  // namespace atwood
