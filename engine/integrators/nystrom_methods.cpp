// Runge-Kutta-Nystrom methods: what they are called, and their steppers.
#include "integrators/families.hpp"

namespace atwood {

std::vector<MethodInfo> nystrom_methods() { return {}; }

template <class S> StepperPointer<S> make_nystrom(StepperRequest<S>&) { return nullptr; }

template StepperPointer<float> make_nystrom(StepperRequest<float>&);
template StepperPointer<double> make_nystrom(StepperRequest<double>&);
template StepperPointer<long double> make_nystrom(StepperRequest<long double>&);
template StepperPointer<Quad> make_nystrom(StepperRequest<Quad>&);

}  // namespace atwood
