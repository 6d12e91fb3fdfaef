// What a method costs beside the rates that it evaluates, from runs in which each evaluation is made several times over:
//
//   time of a run over its evaluations = overhead + k rate,    k = 1, 2, 4, 8
//
// The overhead is the line's value at k = 0: the arithmetic of the stages, step control, and the call itself. It depends on the
// size of the state and not on what a rate costs, so that methods can be compared apart from the equations of one scene.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "validation/metrics/order_statistics.hpp"

namespace atwood {

struct OverheadFit {
  int rounds = 0;        // with a finite time for every k; 0: nothing below is known
  Estimate overhead_ns;  // an evaluation
  Estimate rate_ns;      // one rate
  bool straight =
      true;  // false: the four times lie on no line (the interval of the slopes' ratio leaves out 1, and the
             // slopes differ by more than a tenth): the overhead is then no more than a figure at k = 0
};

// ns[round][i]: nanoseconds an evaluation with each rate made repeats[i] times over; at least two repeats that differ.
// A line by least squares in every round (weights 1 / ns^2: what disturbs a timing is in proportion to it), so that what
// slows one round down stays in it. Estimates are medians over the rounds, their intervals order statistics: ranks of the
// sorted values that enclose the median with 95 % whatever their distribution (sign test; David and Nagaraja, Order
// Statistics, section 7.1). Of fewer than six rounds: the range, which holds it with 1 - 2^(1 - rounds).
OverheadFit fit_overhead(std::span<const int> repeats, const std::vector<std::vector<double>>& ns);

// What `compare` measured of one method.
struct MethodOverhead {
  std::string scenario, family, method;
  std::int64_t steps = 0;
  double evaluations = 0;
  OverheadFit fit;
};

}  // namespace atwood
