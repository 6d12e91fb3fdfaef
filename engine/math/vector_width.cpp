#include "math/vector_width.hpp"

namespace atwood {

#if defined(__x86_64__)
#if defined(__clang__)  // version 14 does not know the levels of the x86-64 psABI by name
#define ATWOOD_HAS_V3 (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
#define ATWOOD_HAS_V4                                                                              \
  (ATWOOD_HAS_V3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&     \
   __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
#else
#define ATWOOD_HAS_V3 __builtin_cpu_supports("x86-64-v3")
#define ATWOOD_HAS_V4 __builtin_cpu_supports("x86-64-v4")
#endif
VectorWidth widest_vectors() {
  if (ATWOOD_HAS_V4) return VectorWidth::v4;
  if (ATWOOD_HAS_V3) return VectorWidth::v3;
  return VectorWidth::narrow;
}
#else
VectorWidth widest_vectors() { return VectorWidth::narrow; }
#endif

}  // namespace atwood
