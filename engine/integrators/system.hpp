// A system of equations as general steppers see it: y' = f(t, y), a span of scalars and a rate with its context.
#pragma once

#include <cstdint>

namespace atwood {

// Instantiated once a scalar, not once a problem. `y` and `dydt` hold `size` scalars and never overlap.
template <class S> struct System {
  int size = 0;
  void* context = nullptr;
  void (*rate_of)(void* context, S t_s, const S* y, S* dydt) = nullptr;
  // Returns a state to its manifold after a step (unit quaternions); null: nothing to do.
  void (*project_of)(void* context, S* y) = nullptr;
  std::int64_t evaluations = 0;  // of the rate, since the start of the run
  std::int64_t epoch = 0;        // grows when the law changes (a thruster switches): cached rates are stale

  void rate(S t_s, const S* y, S* dydt) {
    ++evaluations;
    rate_of(context, t_s, y, dydt);
  }
  void project(S* y) const {
    if (project_of != nullptr) project_of(context, y);
  }
};

}  // namespace atwood
