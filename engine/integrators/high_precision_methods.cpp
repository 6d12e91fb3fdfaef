// Methods for round-off accuracy: what they are called, and their steppers.
#include "integrators/families.hpp"
#include "integrators/radau15.hpp"

namespace atwood {
namespace {

MethodInfo of_tolerance(const std::string& scheme, std::map<std::string, double> claims, const std::string& doc,
                        const std::string& source) {
  MethodInfo info = fixed_step(scheme, std::move(claims), doc, source);
  info.adaptive = true;
  info.settings.insert({"atol_over_rtol", 0.01});
  return info;
}

}  // namespace

std::vector<MethodInfo> high_precision_methods() {
  const std::string sweeps =
      " Positions are integrated twice from the accelerations. The first guess extrapolates the rates of the step before. "
      "Without a tolerance: equal steps, sweeps to round-off. With one: it is the local error wanted, as judged by the last "
      "coefficient of the rates' polynomial; sweeps end when what remains is a tenth of it. Samples by a shorter step.";
  std::vector<MethodInfo> methods{
      of_tolerance("radau15", claims_everywhere(15),
                   "Collocation at the eight Radau nodes that hold the start of the step, order 15, solved by sweeps that "
                   "evaluate all nodes as one batch of eight states." + sweeps + embedded_attitude,
                   "Everhart, in: Dynamics of Comets (1985) 185; Hairer, Norsett, Wanner, Solving ODEs I, theorem II.7.7"),
      of_tolerance("ias15", claims_everywhere(15),
                   "Collocation at the eight Radau nodes that hold the start of the step, order 15, solved node after node, "
                   "each with the newest rates, with compensated summation: few evaluations. A tolerance of 1e-16 or less "
                   "corresponds to IAS15's epsilon of 1e-7 or less, by epsilon^2 = 100 rtol." + sweeps + embedded_attitude,
                   "Rein, Spiegel, MNRAS 446 (2015) 1424, eq. 4 to 11; Everhart (1985)")};
  for (MethodInfo& info : methods) info.settings["compensated"] = true;
  return methods;
}

template <class S> StepperPointer<S> make_high_precision(StepperRequest<S>& request) {
  if (request.scheme == "radau15" || request.scheme == "ias15") {
    const bool sequential = request.scheme == "ias15";
    return std::make_unique<Radau15<S>>(request.model, RadauOptions{sequential, request.flag("compensated")});
  }
  return nullptr;
}

template StepperPointer<float> make_high_precision(StepperRequest<float>&);
template StepperPointer<double> make_high_precision(StepperRequest<double>&);
template StepperPointer<long double> make_high_precision(StepperRequest<long double>&);
template StepperPointer<Quad> make_high_precision(StepperRequest<Quad>&);

}  // namespace atwood
