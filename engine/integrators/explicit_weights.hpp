// The coefficients of an explicit Runge-Kutta step in the scalar of a run, used by the general stepper and by the loops
// that compute the same bits for many steps at once.
#pragma once

#include <vector>

namespace atwood {

// k_i = f(y + h slope_i), y_new = y + h slope_b, then the projection; slope = w_0 k_(stage 0), += w_1 k_(stage 1), ...
// in the order of the row (zeros of the tableau left out).
template <class S> struct ExplicitWeights {
  struct Row {
    std::vector<int> stage;
    std::vector<S> weight;
  };
  std::vector<Row> a;  // one per stage; that of the first is empty
  Row b;
  bool first_same_as_last = false;  // the last stage is the next step's first, and not in b

  int stages() const { return static_cast<int>(a.size()); }
};

}  // namespace atwood
