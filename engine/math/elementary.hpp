// Logarithm, exponential, powers and arc tangent by IEEE additions, products, divisions and square roots alone, so that
// their bits do not depend on the processor. The C library chooses among variants of exp, log, pow, sin, cos and atan2
// (with and without fused multiplication and addition), which differ in the last place now and then.
//
// Double results are computed in long double. Their error is below 0.51 units in the last place, that of power below
//   0.51 + |y log x| / 2048.
// Sine and cosine: math/sin_cos.hpp.
#pragma once

namespace atwood::real {

double log(double x);              // x > 0; NaN below 0, -infinity at 0
double exp(double x);              // 0 below -745.2, infinity above 709.8
double power(double x, double y);  // x > 0; x = 0: 0, 1 or infinity as the sign of y; NaN below 0
double atan2(double y, double x);  // the angle of (x, y) in (-pi, pi]; atan2's values at zeros and infinities

// x^y for the factor of a step size: relative error below 1e-6 for |y| <= 1.
double step_power(double x, double y);

}  // namespace atwood::real
