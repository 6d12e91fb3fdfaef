// What Eigen asks of Wide. std:: has no functions of it, and argument-dependent lookup finds none for a built-in type.
// Heavy: for .cpp files.
#pragma once

#include <quadmath.h>

#include <Eigen/Core>

namespace Eigen {

template <> struct NumTraits<__float128> : GenericNumTraits<__float128> {
  static __float128 epsilon() { return 0x1p-112; }
  static __float128 dummy_precision() { return 0x1p-100; }
  static __float128 highest() { return (2 - epsilon()) * __float128(0x1p16383L); }
  static __float128 lowest() { return -highest(); }
  static int digits10() { return 33; }
};

namespace numext {
template <> inline __float128 abs<__float128>(const __float128& x) { return fabsq(x); }
}  // namespace numext

namespace internal {
template <> struct sqrt_impl<__float128> {
  static __float128 run(const __float128& x) { return sqrtq(x); }
};
}  // namespace internal

}  // namespace Eigen
