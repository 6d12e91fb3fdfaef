// Methods that keep invariants: what they are called, and their steppers.
#include "integrators/families.hpp"

namespace atwood {

std::vector<MethodInfo> conserving_methods() { return {}; }

template <class S> StepperPointer<S> make_conserving(StepperRequest<S>&) { return nullptr; }

template StepperPointer<float> make_conserving(StepperRequest<float>&);
template StepperPointer<double> make_conserving(StepperRequest<double>&);
template StepperPointer<long double> make_conserving(StepperRequest<long double>&);
template StepperPointer<Quad> make_conserving(StepperRequest<Quad>&);

}  // namespace atwood
