// Initial value problems in 60 digits by extrapolation of Gragg's modified midpoint rule (Bulirsch and Stoer).
#pragma once

#include <functional>

#include "number.hpp"

namespace atwood::fuzz {

using State = std::vector<Long>;
using Rate = std::function<void(const Long& t_s, const State& y, State& dydt)>;

// The modified midpoint rule over H in `substeps` parts.
State midpoints(const Rate& f, const Long& t_s, const State& y, const Long& H, int substeps);

// error: of the last column but one, relative to the scales; 1 where the step is not finite
struct Step {
  State y;
  Long error;
};
Step extrapolate(const Rate& f, const Long& t_s, const State& y, const Long& H, const State& scale);

// The states at `times_s`, which ascend from the start's, with a relative error of 10^-digits per step. Components of
// one `kind` (ascending from 0) share their scale. Empty: it needs more than 20 000 steps.
std::vector<State> solve(const Rate& f, const State& start, const std::vector<int>& kind,
                         const std::vector<Long>& times_s, int digits);

// k t_end_s / samples, k = 0 .. samples
std::vector<Long> sample_times(double t_end_s, std::int64_t samples);

}  // namespace atwood::fuzz
