// Adams and BDF: what they are called, and their steppers.
#include "integrators/families.hpp"

namespace atwood {

std::vector<MethodInfo> multistep_methods() { return {}; }

template <class S> StepperPointer<S> make_multistep(StepperRequest<S>&) { return nullptr; }

template StepperPointer<float> make_multistep(StepperRequest<float>&);
template StepperPointer<double> make_multistep(StepperRequest<double>&);
template StepperPointer<long double> make_multistep(StepperRequest<long double>&);
template StepperPointer<Quad> make_multistep(StepperRequest<Quad>&);

}  // namespace atwood
