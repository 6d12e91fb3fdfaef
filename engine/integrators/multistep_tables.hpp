// Coefficients of linear multistep methods with equal steps, generated from the integrals and differences that define
// them.
#pragma once

#include <vector>

#include "math/scalar.hpp"

namespace atwood {

// One step from y_n over h, with past increments d_i = y_(n+1-i) - y_(n-i) and rates f_(n-j):
//
//   y_(n+1) = y_n + sum_(i>=1) increment_i d_i + h (implicit f_(n+1) + sum_(j>=0) rate_j f_(n-j))
//
// BDF written in increments keeps the round-off of y out of its differences. The guess is of the same form, explicit.
struct MultistepTable {
  int order;
  std::vector<Quad> increment, rate;              // increment[0] belongs to d_1
  Quad implicit;                                  // 0: explicit
  std::vector<Quad> guess_increment, guess_rate;  // no more terms than above
};

MultistepTable adams_bashforth(int order);  // Hairer, Norsett, Wanner, Solving ODEs I (2nd ed.), eq. III.1.5
MultistepTable adams_moulton(int order);    // eq. III.1.8': order - 1 past rates and the new one
MultistepTable bdf(int order);              // eq. III.1.22': sum_(m=1..order) 1/m nabla^m y_(n+1) = h f_(n+1)

}  // namespace atwood
