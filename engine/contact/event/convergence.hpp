// How an iteration ended.
#pragma once

namespace atwood::event {

// `residual`: the last change relative to the size of the solution, unless the solver says otherwise.
struct Convergence {
  int iterations = 0;
  double residual = 0;
  bool converged = true;
};

}  // namespace atwood::event
