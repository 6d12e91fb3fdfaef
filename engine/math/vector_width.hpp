// Loops over lanes, run at the machine's own vector width: one source, three builds of it in the same binary.
//
//   at_width(widest_vectors(), [&]() __attribute__((always_inline)) { loops over lanes });
//
// The kernel is inlined into a function of each instruction set, and the compiler lays its lane loops out anew there.
// Each lane is computed by the same IEEE operations in the same order at every width (no contraction, no approximate
// instructions, no sum across lanes), so the bits do not depend on the machine. What the kernel calls must be
// always_inline, too.
#pragma once

#include <type_traits>

// What a lane kernel is made of.
#define ATWOOD_INLINE [[gnu::always_inline]] inline

// Before a loop whose iterations do not depend on each other.
#if defined(__clang__)
#define ATWOOD_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define ATWOOD_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace atwood {

enum class VectorWidth { narrow, v3, v4 };  // the plain target; x86-64-v3 (AVX2: 256 bits); x86-64-v4 (AVX-512)

// The scalars that vector registers hold.
template <class S> inline constexpr bool has_vector_lanes = std::is_same_v<S, float> || std::is_same_v<S, double>;

// The widest that this machine runs, or a narrower one that the environment asks for: ATWOOD_VECTOR_WIDTH=narrow, v3 or
// v4, with which tests compare the bits of all widths on one machine.
VectorWidth widest_vectors();
bool knows_asked_width();  // false: the variable has another value

#if defined(__x86_64__)
#if defined(__clang__)  // has no prefer-vector-width in a function's target
#define ATWOOD_V4 "arch=x86-64-v4"
#else
#define ATWOOD_V4 "arch=x86-64-v4,prefer-vector-width=512"
#endif
template <class Kernel> [[gnu::target(ATWOOD_V4), gnu::noinline]] void run_at_v4(const Kernel& kernel) { kernel(); }
#undef ATWOOD_V4
// Without fused multiply-adds: GCC 12 makes some of pairs of products (vfmaddsub) even where contraction is off.
template <class Kernel> [[gnu::target("arch=x86-64-v3,no-fma"), gnu::noinline]] void run_at_v3(const Kernel& kernel) {
  kernel();
}

template <class Kernel> void at_width(VectorWidth width, const Kernel& kernel) {
  if (width == VectorWidth::v4) run_at_v4(kernel);
  else if (width == VectorWidth::v3) run_at_v3(kernel);
  else kernel();
}

// A kernel without lanes, in scalars of float and double: instructions of three operands spare copies. With AVX-512 too
// it takes those of AVX2, for AVX-512 cannot be had without fused multiply-adds.
template <class S, class Kernel> void run_scalar(VectorWidth width, const Kernel& kernel) {
  if constexpr (has_vector_lanes<S>)
    if (width != VectorWidth::narrow) return run_at_v3(kernel);
  kernel();
}
#else
template <class Kernel> void at_width(VectorWidth, const Kernel& kernel) { kernel(); }
template <class S, class Kernel> void run_scalar(VectorWidth, const Kernel& kernel) { kernel(); }
#endif

}  // namespace atwood
