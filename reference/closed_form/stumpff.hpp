// G_k(beta, s) = s^k c_k(beta s^2), Stumpff's functions c_k(x) = 1/k! - x/(k+2)! + x^2/(k+4)! - ...:
//   G_0 = cos(sqrt(beta) s), G_1 = sin(sqrt(beta) s) / sqrt(beta), and d G_{k+1} / ds = G_k, for either sign of beta.
#pragma once

#include "closed_form/number.hpp"

namespace atwood::closed_form {

template <class S> std::array<S, 5> stumpff(S beta, S s) {
  const S x = beta * s * s;
  std::array<S, 5> G;
  if (magnitude(x) < 1) {  // the series of the two highest; G_{k} = s^k / k! - beta G_{k+2} is exact downwards
    for (const int k : {4, 3}) {
      S term = 1, sum = 0;
      for (int j = 1; j <= k; ++j) term *= s / j;
      const S least = magnitude(term) * unit_round_off<S>() / 8;
      for (int j = k; magnitude(term) > least; j += 2) {
        sum += term;
        term *= -x / (j + 1) / (j + 2);
      }
      G[k] = sum;
    }
    G[2] = s * s / 2 - beta * G[4];
    G[1] = s - beta * G[3];
    G[0] = 1 - beta * G[2];
    return G;
  }
  const S rate = sqrt(magnitude(beta)), angle = rate * s;
  if (beta > 0) {
    const S half = sin(angle / 2);
    G[0] = cos(angle);
    G[1] = sin(angle) / rate;
    G[2] = 2 * half * half / beta;
  } else {
    const S half = sinh(angle / 2);
    G[0] = cosh(angle);
    G[1] = sinh(angle) / rate;
    G[2] = -2 * half * half / beta;
  }
  G[3] = (s - G[1]) / beta;
  G[4] = (s * s / 2 - G[2]) / beta;
  return G;
}

}  // namespace atwood::closed_form
