#include "math/scalar.hpp"

#include <quadmath.h>

#include "math/elementary.hpp"
#include "math/sin_cos.hpp"

namespace atwood::real {

void sin_cos(double x, double& sine, double& cosine) {
  if (abs(x) < trigonometry::kMaxArgument) return trigonometry::sin_cos_within(x, sine, cosine);
  long double s, c;  // NaN and infinity too; the C library has one variant for long double
  sin_cos(static_cast<long double>(x), s, c);
  sine = static_cast<double>(s);
  cosine = static_cast<double>(c);
}
double sin(double x) {
  double sine, cosine;
  sin_cos(x, sine, cosine);
  return sine;
}
double cos(double x) {
  double sine, cosine;
  sin_cos(x, sine, cosine);
  return cosine;
}

void sin_cos(float x, float& sine, float& cosine) {
  double s, c;
  sin_cos(static_cast<double>(x), s, c);
  sine = static_cast<float>(s);
  cosine = static_cast<float>(c);
}
float sin(float x) { return static_cast<float>(sin(static_cast<double>(x))); }
float cos(float x) { return static_cast<float>(cos(static_cast<double>(x))); }
float atan2(float y, float x) { return static_cast<float>(atan2(double(y), double(x))); }

Quad sqrt(Quad x) { return sqrtq(x); }
Quad sin(Quad x) { return sinq(x); }
Quad cos(Quad x) { return cosq(x); }
void sin_cos(Quad x, Quad& sine, Quad& cosine) { sincosq(x, &sine, &cosine); }
Quad atan2(Quad y, Quad x) { return atan2q(y, x); }
Quad floor(Quad x) { return floorq(x); }

}  // namespace atwood::real
