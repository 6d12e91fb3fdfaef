// The step-size control of adaptive methods.
#pragma once

namespace atwood {

// Proportional-integral control as in Hairer, Wanner, Solving ODEs II, eq. IV.2.43 and the code DOPRI5:
//   h_new = h safety err_n^-(1/k - 3/4 beta) err_(n-1)^beta, within [least, most] h, k = 1 + the estimate's order.
struct StepLimits {
  double safety = 0.9, beta = 0.04, least = 0.2, most = 10;
};

template <class S> class StepControl {
 public:
  explicit StepControl(int estimate_order, const StepLimits& limits = {});
  // The next step [s] after one of h_s whose scaled error was `error`; accepted if error <= 1. Stores the error for the
  // next call.
  S next_step(S h_s, S error);
  bool accepted() const { return accepted_; }

 private:
  StepLimits limits_;
  S exponent_, error_before_;
  bool accepted_ = true;
};

}  // namespace atwood
