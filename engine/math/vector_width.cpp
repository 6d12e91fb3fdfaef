#include "math/vector_width.hpp"

namespace atwood {

#if defined(__x86_64__)
VectorWidth widest_vectors() {
  if (__builtin_cpu_supports("x86-64-v4")) return VectorWidth::v4;
  if (__builtin_cpu_supports("x86-64-v3")) return VectorWidth::v3;
  return VectorWidth::narrow;
}
#else
VectorWidth widest_vectors() { return VectorWidth::narrow; }
#endif

}  // namespace atwood
