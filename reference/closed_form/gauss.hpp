// Gauss-Legendre nodes and weights on [0, 1], by Newton's method on the recurrence of the polynomials. A node for which
// the method does not converge is not a number.
#pragma once

#include <limits>
#include <vector>

#include "closed_form/number.hpp"

namespace atwood::closed_form {

template <class S> struct GaussRule { std::vector<S> node, weight; };

template <class S> GaussRule<S> gauss_rule(int n) {
  GaussRule<S> rule;
  for (int k = 0; k < n; ++k) {
    S x = cos(pi<S>() * (S(k) + S(0.75)) / (S(n) + S(0.5))), slope = 0, change = 0;
    for (int tries = 0; tries < 12; ++tries) {
      S before = 1, now = x;  // P_{j-1}, P_j
      for (int j = 1; j < n; ++j) {
        const S next = ((2 * j + 1) * x * now - j * before) / (j + 1);
        before = now;
        now = next;
      }
      slope = n * (x * now - before) / (x * x - 1);
      change = now / slope;
      x -= change;
    }
    if (!(magnitude(change) <= S(n) * unit_round_off<S>())) x = S(std::numeric_limits<double>::quiet_NaN());
    rule.node.push_back((1 + x) / 2);
    rule.weight.push_back(1 / ((1 - x * x) * slope * slope));
  }
  return rule;
}

}  // namespace atwood::closed_form
