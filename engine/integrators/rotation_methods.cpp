// Methods for rotating bodies: what they are called, and their steppers.
#include "integrators/families.hpp"

namespace atwood {

std::vector<MethodInfo> rotation_methods() { return {}; }

template <class S> StepperPointer<S> make_rotation(StepperRequest<S>&) { return nullptr; }

template StepperPointer<float> make_rotation(StepperRequest<float>&);
template StepperPointer<double> make_rotation(StepperRequest<double>&);
template StepperPointer<long double> make_rotation(StepperRequest<long double>&);
template StepperPointer<Quad> make_rotation(StepperRequest<Quad>&);

}  // namespace atwood
