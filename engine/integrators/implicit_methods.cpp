// Implicit one-step methods: what they are called, and their steppers.
#include "integrators/families.hpp"
#include "integrators/implicit_euler.hpp"

namespace atwood {

std::vector<MethodInfo> implicit_methods() {
  return {
      fixed_step("implicit-euler", claims_everywhere(1),
                 "y_new = y + h f(t + h, y_new), solved to round-off by fixed-point sweeps, or by simplified Newton "
                 "iteration where they contract slowly." +
                     embedded_attitude,
                 "Hairer, Wanner, Solving ODEs II (2nd ed.), eq. IV.1.8")};
}

template <class S> StepperPointer<S> make_implicit(StepperRequest<S>& request) {
  if (request.scheme == "implicit-euler") return std::make_unique<ImplicitEuler<S>>(request.model.system());
  return nullptr;
}

template StepperPointer<float> make_implicit(StepperRequest<float>&);
template StepperPointer<double> make_implicit(StepperRequest<double>&);
template StepperPointer<long double> make_implicit(StepperRequest<long double>&);
template StepperPointer<Quad> make_implicit(StepperRequest<Quad>&);

}  // namespace atwood
