#include "math/scalar.hpp"

#include <quadmath.h>

namespace atwood::real {

Quad sqrt(Quad x) { return sqrtq(x); }
Quad sin(Quad x) { return sinq(x); }
Quad cos(Quad x) { return cosq(x); }
void sin_cos(Quad x, Quad& sine, Quad& cosine) { sincosq(x, &sine, &cosine); }
Quad atan2(Quad y, Quad x) { return atan2q(y, x); }
Quad floor(Quad x) { return floorq(x); }

}  // namespace atwood::real
