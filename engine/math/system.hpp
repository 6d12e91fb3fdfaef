// A system of first-order equations y' = f(t, y): a span of scalars, and the rate f as a function with its context.
#pragma once

#include <cstdint>

#include "protocol/solver_report.hpp"

namespace atwood {

// Instantiated once for each scalar, not for each problem. `y` and `dydt` hold `size` scalars and never overlap.
template <class S> struct System {
  int size = 0;
  void* context = nullptr;
  void (*rate_of)(void* context, S t_s, const S* y, S* dydt) = nullptr;
  // Returns a state to its manifold after a step (unit quaternions); null: nothing to do.
  void (*project_of)(void* context, S* y) = nullptr;
  // The same as an increment of the state (0 where nothing changes), for compensated sums.
  void (*projection_of)(void* context, const S* y, S* change) = nullptr;
  // The rates of `count` states at once, component after component: component i of state k is y[i * count + k], at time
  // t_s[k]; dydt likewise. Null: rates() takes the states one by one.
  void (*rates_of)(void* context, int count, const S* t_s, const S* y, S* dydt) = nullptr;
  std::int64_t evaluations = 0;  // of the rate, since the start of the run
  SolverTallies solvers = {};    // how the solves of the run ended
  std::int64_t epoch = 0;        // grows when the law changes (a thruster switches): cached rates are stale

  void rate(S t_s, const S* y, S* dydt) {
    ++evaluations;
    rate_of(context, t_s, y, dydt);
  }
  // Counts as `count` evaluations. `scratch`: 2 size scalars, used where there is no rates_of. Bit for bit what rate()
  // gives for each state.
  void rates(int count, const S* t_s, const S* y, S* dydt, S* scratch) {
    evaluations += count;
    if (rates_of != nullptr) return rates_of(context, count, t_s, y, dydt);
    for (int k = 0; k < count; ++k) {
      for (int i = 0; i < size; ++i) scratch[i] = y[i * count + k];
      rate_of(context, t_s[k], scratch, scratch + size);
      for (int i = 0; i < size; ++i) dydt[i * count + k] = scratch[size + i];
    }
  }
  void project(S* y) const {
    if (project_of != nullptr) project_of(context, y);
  }
};

}  // namespace atwood
