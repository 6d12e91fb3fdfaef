#include "integrators/adaptive.hpp"

#include "math/elementary.hpp"
#include "math/scalar.hpp"

namespace atwood {

template <class S>
StepControl<S>::StepControl(int estimate_order, const StepLimits& limits)
    : limits_(limits), exponent_(S(1) / S(1 + estimate_order) - S(0.75) * S(limits.beta)), error_before_(S(1e-4)) {}

template <class S> S StepControl<S>::next_step(S h_s, S error) {
  const auto [safety, beta, least, most] = limits_;
  // Powers are taken in double: a step-size factor needs no more digits.
  const double now = static_cast<double>(error);
  const bool rejected_before = !accepted_;
  accepted_ = now <= 1;
  if (!accepted_) {  // NaN too
    const double factor = now > 1 ? safety * real::step_power(now, -static_cast<double>(exponent_)) : least;
    return h_s * S(real::max(factor, least));
  }
  double factor = most;
  if (now > 0)
    factor = safety * real::step_power(now, -static_cast<double>(exponent_)) *
             real::step_power(static_cast<double>(error_before_), beta);
  factor = real::min(real::max(factor, least), rejected_before ? 1.0 : most);
  error_before_ = real::max(error, S(1e-4));
  return h_s * S(factor);
}

template class StepControl<float>;
template class StepControl<double>;
template class StepControl<long double>;
template class StepControl<Quad>;

}  // namespace atwood
