// Methods for round-off accuracy: what they are called, and their steppers.
#include "integrators/families.hpp"

namespace atwood {

std::vector<MethodInfo> high_precision_methods() { return {}; }

template <class S> StepperPointer<S> make_high_precision(StepperRequest<S>&) { return nullptr; }

template StepperPointer<float> make_high_precision(StepperRequest<float>&);
template StepperPointer<double> make_high_precision(StepperRequest<double>&);
template StepperPointer<long double> make_high_precision(StepperRequest<long double>&);
template StepperPointer<Quad> make_high_precision(StepperRequest<Quad>&);

}  // namespace atwood
