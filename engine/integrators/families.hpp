// The families of methods. Each lists its methods and makes their steppers; catalogue.cpp collects them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "integrators/stepper.hpp"
#include "protocol/method.hpp"
#include "rigid/model.hpp"

namespace atwood {

// A request for a stepper. `settings` holds the method's defaults replaced by the caller's values, which were checked.
template <class S> struct StepperRequest {
  std::string scheme;
  System<S>& system;     // outlives the stepper
  RigidModel<S>* model;  // whose system it is; null: a bare system of equations, which has neither bodies nor positions
  Settings settings;

  bool flag(const char* name) const { return std::get<bool>(settings.at(name)); }
  double number(const char* name) const { return std::get<double>(settings.at(name)); }
  std::int64_t count(const char* name) const { return std::get<std::int64_t>(settings.at(name)); }
};

template <class S> using StepperPointer = std::unique_ptr<Stepper<S>>;
template <class S> using StepperResult = Result<StepperPointer<S>>;

// A family returns a null pointer for a scheme that is not its own, and a fault for one of its own that cannot keep its
// claim on this system.
#define ATWOOD_FAMILY(name)                 \
  std::vector<MethodInfo> name##_methods(); \
  template <class S> StepperResult<S> make_##name(const StepperRequest<S>& request)

ATWOOD_FAMILY(explicit_runge_kutta);  // tableaux, with error control and with equal steps
ATWOOD_FAMILY(nystrom);               // second-order systems x'' = a(t, x)
ATWOOD_FAMILY(partitioned);           // kicks and drifts: symplectic Euler, Verlet, leapfrog
ATWOOD_FAMILY(composition);           // symmetric compositions of those, of order 4 to 8; charges
ATWOOD_FAMILY(rotation);              // the free top and Lie group methods
ATWOOD_FAMILY(implicit);              // Euler, collocation, diagonally implicit, generalised alpha
ATWOOD_FAMILY(multistep);             // Adams and BDF
ATWOOD_FAMILY(conserving);            // discrete gradients, projection, relaxation
ATWOOD_FAMILY(high_precision);        // Radau 15, extrapolation, Taylor
ATWOOD_FAMILY(constrained);           // mechanisms in maximal coordinates

#undef ATWOOD_FAMILY

// ---- how families refuse -----------------------------------------------------------------------------------------
// No bodies: neither a null model nor that of a bare problem has positions and velocities.
template <class S> bool without_bodies(const StepperRequest<S>& request) {
  return request.model == nullptr || request.model->bare_problem();
}
inline Fault cannot_step(const std::string& scheme, const std::string& why) { return {"atwood/" + scheme + " " + why}; }
// In the coordinates of joints accelerations depend on rates and the mass on coordinates.
template <class S> bool has_mechanisms(const StepperRequest<S>& request) {
  return request.model != nullptr && request.model->tree() != nullptr;
}
// `assumes`: what the method needs that coordinates of joints do not give.
inline Fault cannot_step_mechanisms(const std::string& scheme, const std::string& assumes) {
  return {"atwood/" + scheme + " cannot step a mechanism in joint coordinates: " + assumes};
}
// `needs`: "needs positions and velocities", "moves bodies".
inline Fault cannot_step_bare(const std::string& scheme, const std::string& needs) {
  return cannot_step(scheme, needs + "; this problem is a system of equations without bodies");
}

// Methods whose model has all bodies free and all joints as constraints (integrators/maximal_coordinates.hpp).
bool steps_maximal_coordinates(const std::string& scheme);

// ---- how families write their entries -------------------------------------------------------------------------
std::map<std::string, double> claims_everywhere(double order);  // point-mass, velocity-dependent, rotation
// Those and mechanism: methods for first-order systems, which need not know what the components of the state mean.
std::map<std::string, double> claims_in_any_coordinates(double order);
MethodInfo fixed_step(
    const std::string& scheme, std::map<std::string, double> claims, const std::string& doc,
    const std::string& source);  // equal steps; settings: scalar, compensated, gravity, opening, threads
Setting atol_over_rtol();
// With a tolerance too; settings: those and the step control's.
MethodInfo with_tolerance(const std::string& scheme, std::map<std::string, double> claims, const std::string& doc,
                          const std::string& source);
// How general steppers integrate attitudes: a sentence for their doc strings.
extern const std::string embedded_attitude;

}  // namespace atwood
