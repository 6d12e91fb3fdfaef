// The cost of a method besides the rates that it evaluates, from runs in which each evaluation is repeated k times:
//
//   time of a run / its evaluations = overhead + k rate,    k = 1, 2, 4, 8
//
// The overhead is the line's value at k = 0: the arithmetic of the stages, step control, and the call itself. It
// depends on the size of the state and not on the cost of a rate, so that methods can be compared independently of a
// scene's equations.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "validation/metrics/order_statistics.hpp"

namespace atwood {

struct OverheadFit {
  int rounds = 0;        // with a finite time for every k; 0: nothing below is known
  Estimate overhead_ns;  // per evaluation
  Estimate rate_ns;      // one rate
  // False: the four times do not lie on a line (the interval of the slopes' ratio excludes 1, and the slopes differ by
  // more than 10 %), so that the overhead is only an extrapolated figure.
  bool straight = true;
  // False: the interval of the overhead is below zero, which no cost is: other load lengthened the longer runs more,
  // and the overhead is not known.
  bool possible = true;
};

// ns[round][i]: nanoseconds per evaluation with each rate repeated repeats[i] times; at least two different repeats. A
// line by least squares in every round (weights 1 / ns^2: disturbances of a timing are proportional to it), so that
// load during one round affects only that round. Estimates are medians over the rounds, their intervals order
// statistics: ranks of the sorted values that enclose the median with 95 % for every distribution (sign test; David and
// Nagaraja, Order Statistics, section 7.1). For n < 6 rounds: the range, which contains it with 1 - 2^(1 - n).
OverheadFit fit_overhead(std::span<const int> repeats, const std::vector<std::vector<double>>& ns);

// The overhead of one method as `compare` measured it.
struct MethodOverhead {
  std::string scenario, family, method;
  std::int64_t steps = 0;
  double evaluations = 0;
  OverheadFit fit;
  bool busy = false;  // the machine, while it was measured
};

}  // namespace atwood
