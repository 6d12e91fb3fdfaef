// Many numbers of a kind at once, one a vector lane. Each lane does what the scalar code does, in the same order, so a
// lane's result has the same bits at any vector width (vector_width.hpp).
#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

#include "math/quat.hpp"
#include "math/vector_width.hpp"

namespace atwood {

#define ATWOOD_INLINED __attribute__((always_inline))  // of a lambda

inline constexpr int kLaneCount = 8;  // doubles of an AVX-512 register

template <class S> struct alignas(kLaneCount * sizeof(S)) LaneBlock { S lane[kLaneCount]; };
template <class S> using LaneArray = std::vector<LaneBlock<S>>;  // aligned to whole registers
template <class S> const S* lanes_of(const LaneBlock<S>* blocks) { return blocks == nullptr ? nullptr : blocks->lane; }
template <class S> S* lanes_of(LaneArray<S>& blocks) { return blocks.empty() ? nullptr : blocks.front().lane; }

// f(k) for each lane; lanes are independent of each other. A full block has a trip count that the compiler knows.
template <class F> ATWOOD_INLINE void for_lanes(int count, const F& f) {
  if (count == kLaneCount) {
    ATWOOD_INDEPENDENT
#if !defined(__clang__)
#pragma GCC unroll 1  // before the vectoriser has seen it
#endif
    for (int k = 0; k < kLaneCount; ++k) f(k);
  } else {
    ATWOOD_INDEPENDENT
    for (int k = 0; k < count; ++k) f(k);
  }
}

// kernel(width) at that vector width. float and double have vector lanes; the wider scalars run the same loops plainly.
template <VectorWidth width> using Width = std::integral_constant<VectorWidth, width>;
template <class S, class Kernel> void in_lanes(VectorWidth width, const Kernel& kernel) {
  constexpr bool vectors = std::is_same_v<S, float> || std::is_same_v<S, double>;
#if defined(__x86_64__)
  if constexpr (vectors) {
    if (width == VectorWidth::v4) return run_at_v4([&]() ATWOOD_INLINED { kernel(Width<VectorWidth::v4>{}); });
    if (width == VectorWidth::v3) return run_at_v3([&]() ATWOOD_INLINED { kernel(Width<VectorWidth::v3>{}); });
  }
#endif
  kernel(Width<VectorWidth::narrow>{});
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
