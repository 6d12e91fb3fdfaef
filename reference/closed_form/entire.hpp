// Functions of a square that may be negative, so that one formula holds for oscillations and for decay.
#pragma once

#include "closed_form/number.hpp"

namespace atwood::closed_form {

// cosh(sqrt y) and sinh(sqrt y) / sqrt y, entire in y.
template <class S> S cosh_root(S y) { return y < 0 ? cos(sqrt(-y)) : cosh(sqrt(y)); }
template <class S> S sinhc_root(S y) {
  if (magnitude(y) > 1) return y < 0 ? sin(sqrt(-y)) / sqrt(-y) : sinh(sqrt(y)) / sqrt(y);
  S term = 1, sum = 0;
  for (int k = 1; magnitude(term) > unit_round_off<S>() / 8; ++k) {
    sum += term;
    term *= y / (2 * k) / (2 * k + 1);
  }
  return sum;
}

}  // namespace atwood::closed_form
