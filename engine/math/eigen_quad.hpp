// What Eigen asks of Quad where it multiplies and adds; std:: has no functions of it. Heavy: for .cpp files.
#pragma once

#include <Eigen/Core>

#include "math/scalar.hpp"

namespace Eigen {

template <> struct NumTraits<atwood::Quad> : GenericNumTraits<atwood::Quad> {
  static atwood::Quad epsilon() { return atwood::real::epsilon<atwood::Quad>(); }
  static atwood::Quad dummy_precision() { return atwood::Quad(0x1p-100); }
  static atwood::Quad highest() { return (2 - epsilon()) * atwood::Quad(0x1p16383L); }
  static atwood::Quad lowest() { return -highest(); }
  static int digits10() { return 33; }
};

}  // namespace Eigen
