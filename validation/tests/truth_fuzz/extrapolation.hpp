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

inline constexpr int kMaxSteps = 20'000;

// An integration from `start` at t_s with a relative error of 10^-digits per step. Components of one `kind` (ascending
// from 0) share their scale. Rates may change between two calls of `advance`.
class Integration {
 public:
  Integration(const Rate& f, const State& start, const std::vector<int>& kind, const Long& t_s,
              const Long& first_step_s, int digits);
  bool advance(const Long& target_s);  // false: it needs more than kMaxSteps
  const State& state() const { return y_; }

 private:
  void widen_scale(State& scale, const State& y) const;

  const Rate& f_;
  State y_, scale_;
  std::vector<int> kind_;
  Long t_s_, step_s_, asked_;
  int steps_ = 0;
};

// The states at `times_s`, which ascend from the start's, as Integration. Empty: it needs more than
// kMaxSteps.
std::vector<State> solve(const Rate& f, const State& start, const std::vector<int>& kind,
                         const std::vector<Long>& times_s, int digits);

// k t_end_s / samples, k = 0 .. samples
std::vector<Long> sample_times(double t_end_s, std::int64_t samples);

}  // namespace atwood::fuzz
