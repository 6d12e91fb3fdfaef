// Symmetric compositions: what they are called, and their steppers.
#include "integrators/families.hpp"

namespace atwood {

std::vector<MethodInfo> composition_methods() { return {}; }

template <class S> StepperPointer<S> make_composition(StepperRequest<S>&) { return nullptr; }

template StepperPointer<float> make_composition(StepperRequest<float>&);
template StepperPointer<double> make_composition(StepperRequest<double>&);
template StepperPointer<long double> make_composition(StepperRequest<long double>&);
template StepperPointer<Quad> make_composition(StepperRequest<Quad>&);

}  // namespace atwood
