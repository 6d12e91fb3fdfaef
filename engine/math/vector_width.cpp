#include "math/vector_width.hpp"

#include <cstdlib>
#include <string_view>

namespace atwood {
namespace {

#if defined(__x86_64__) && defined(__clang__)  // before version 16 it accepts features, not levels
VectorWidth machine_width() {
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
                  __builtin_cpu_supports("bmi2");
  const bool v4 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  return v3 && v4 ? VectorWidth::v4 : v3 ? VectorWidth::v3 : VectorWidth::narrow;
}
#elif defined(__x86_64__)
VectorWidth machine_width() {
  if (__builtin_cpu_supports("x86-64-v4")) return VectorWidth::v4;
  if (__builtin_cpu_supports("x86-64-v3")) return VectorWidth::v3;
  return VectorWidth::narrow;
}
#else
VectorWidth machine_width() { return VectorWidth::narrow; }
#endif

std::string_view asked_width() {
  const char* asked = std::getenv("ATWOOD_VECTOR_WIDTH");
  return asked ? asked : "";
}

}  // namespace

bool knows_asked_width() {
  const std::string_view asked = asked_width();
  return asked.empty() || asked == "narrow" || asked == "v3" || asked == "v4";
}

VectorWidth widest_vectors() {
  static const VectorWidth width = [] {
    const std::string_view asked = asked_width();
    const VectorWidth most = asked == "narrow" ? VectorWidth::narrow
                             : asked == "v3"   ? VectorWidth::v3
                                               : VectorWidth::v4;
    return most < machine_width() ? most : machine_width();
  }();
  return width;
}

}  // namespace atwood
