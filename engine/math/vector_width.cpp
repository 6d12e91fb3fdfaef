#include "math/vector_width.hpp"

namespace atwood {

#if defined(__x86_64__) && defined(__clang__)  // before version 16 it accepts features, not levels
VectorWidth widest_vectors() {
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
                  __builtin_cpu_supports("bmi2");
  const bool v4 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  return v3 && v4 ? VectorWidth::v4 : v3 ? VectorWidth::v3 : VectorWidth::narrow;
}
#elif defined(__x86_64__)
VectorWidth widest_vectors() {
  if (__builtin_cpu_supports("x86-64-v4")) return VectorWidth::v4;
  if (__builtin_cpu_supports("x86-64-v3")) return VectorWidth::v3;
  return VectorWidth::narrow;
}
#else
VectorWidth widest_vectors() { return VectorWidth::narrow; }
#endif

}  // namespace atwood
