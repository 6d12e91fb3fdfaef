// What Eigen asks of Quad where it multiplies and adds; std:: has no functions of it. Heavy: for .cpp files.
#pragma once

#include <Eigen/Core>

namespace Eigen {

// Word for word as in the reference's header: tests link both.
template <> struct NumTraits<__float128> : GenericNumTraits<__float128> {
  static __float128 epsilon() { return 0x1p-112; }
  static __float128 dummy_precision() { return 0x1p-100; }
  static __float128 highest() { return (2 - epsilon()) * __float128(0x1p16383L); }
  static __float128 lowest() { return -highest(); }
  static int digits10() { return 33; }
};

}  // namespace Eigen
