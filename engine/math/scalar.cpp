#include "math/scalar.hpp"

#include <quadmath.h>

namespace atwood::real {

Quad sqrt(Quad x) { return sqrtq(x); }
Quad sin(Quad x) { return sinq(x); }
Quad cos(Quad x) { return cosq(x); }

}  // namespace atwood::real
