// Registers of four doubles or eight floats, for AVX2; math/pack.hpp has those of eight numbers.
#pragma once

#include "math/pack.hpp"

namespace atwood::fluid {

template <class S> struct RegisterOf {};
template <> struct RegisterOf<float> { using Type = FloatPack; };
template <> struct RegisterOf<double> { using Type = FourDoubles; };
// What a machine of this width holds in one register. Of the plain target as much, in two.
template <class S, VectorWidth width>
using Register = std::conditional_t<width == VectorWidth::v4, Pack<S>, typename RegisterOf<S>::Type>;

// Two numbers from each address, in one register: loads do it, where GCC would shuffle registers.
template <VectorWidth width> ATWOOD_INLINE RegisterOf<double>::Type join_pairs(const double* low, const double* high) {
  TwoDoubles pairs[2];
  __builtin_memcpy(&pairs[0], low, sizeof(TwoDoubles));
#if defined(__x86_64__) && !defined(__clang__)
  struct Two {
    double of[2];
  };
  const Two& other = *reinterpret_cast<const Two*>(high);
  RegisterOf<double>::Type joined = __builtin_shufflevector(pairs[0], pairs[0], 0, 1, -1, -1);
  if constexpr (width == VectorWidth::v4) {
    asm("vinsertf64x2 $1, %1, %0, %0" : "+v"(joined) : "m"(other));
    return joined;
  }
  if constexpr (width == VectorWidth::v3) {
    asm("vinsertf128 $1, %1, %0, %0" : "+x"(joined) : "m"(other));
    return joined;
  }
#endif
  __builtin_memcpy(&pairs[1], high, sizeof(TwoDoubles));
  return __builtin_shufflevector(pairs[0], pairs[1], 0, 1, 2, 3);
}

}  // namespace atwood::fluid
