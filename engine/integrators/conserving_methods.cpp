// Methods that keep invariants: their ids, documentation and steppers.
#include "integrators/conserving_correction.hpp"
#include "integrators/conserving_gradient.hpp"
#include "integrators/families.hpp"

namespace atwood {
namespace {

const std::string refuses =
    " Scenes whose energy is not conserved (drag, dashpots, thrusters, drives, springs off a body's centre) are "
    "refused.";
const std::string midpoint_top =
    " A free body's rate and quaternion follow the implicit midpoint rule, which keeps rotational energy, the size "
    "of the angular momentum and the quaternion's length." +
    refuses;

}  // namespace

std::vector<MethodInfo> conserving_methods() {
  return {fixed_step(
              "average-vector-field", claims_everywhere(2),
              "v_new - v = h times the mean acceleration over the segment from p to p_new, p_new - p = h (v + v_new) / "
              "2: the energy is conserved. The mean is Gauss's of nine nodes: exact for potentials of degree up to 18, "
              "and for Kepler's 1 / r to about (|p_new - p| / 4 r)^18; solved to the round-off of the scalar." +
                  midpoint_top,
              "Quispel, McLaren, J. Phys. A 41 (2008) 045206; Celledoni et al., ESAIM Math. Model. Numer. Anal. 43 "
              "(2009) 645"),
          fixed_step(
              "discrete-gradient", claims_everywhere(2),
              "v_new - v = -h/m times a discrete gradient of the potential, p_new - p = h (v + v_new) / 2: energy is "
              "conserved to the round-off of the scalar, and so are momentum and, where forces are central, angular "
              "momentum, because the gradient is the difference quotient of the potentials by the squared distances." +
                  midpoint_top,
              "LaBudde, Greenspan, J. Comput. Phys. 15 (1974) 134; Gonzalez, J. Nonlinear Sci. 6 (1996) 449"),
          fixed_step(
              "projected-rk4", claims_everywhere(4),
              "Classical RK4, then projection onto the nearest state with the run's energy, its angular momentum where "
              "every force is central, and each free body's rotational energy and angular momentum." +
                  refuses + embedded_attitude,
              "Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), algorithm IV.4.2"),
          fixed_step(
              "relaxation-rk4", claims_everywhere(4),
              "Classical RK4 with its increment scaled by gamma = 1 + O(h^3) such that the run's energy is conserved; "
              "the step then ends at t + gamma h. A second relaxed step covers the remaining (1 - gamma) h, so that "
              "samples are taken at the exact times. Four to eight evaluations per step." +
                  refuses + embedded_attitude,
              "Ketcheson, SIAM J. Numer. Anal. 57 (2019) 2850; Ranocha, Sayyari, Dalcin, Parsani, Ketcheson, SIAM J. "
              "Sci. Comput. 42 (2020) A612")};
}

template <class S> StepperResult<S> make_conserving(const StepperRequest<S>& request) {
  using Gradient = DiscreteGradient<S>;
  const std::string& scheme = request.scheme;
  const bool known = scheme == "average-vector-field" || scheme == "discrete-gradient" || scheme == "projected-rk4" ||
                     scheme == "relaxation-rk4";
  if (!known) return StepperPointer<S>{};
  if (request.model == nullptr) return cannot_step_bare(scheme, "needs an energy to keep");
  if (has_mechanisms(request))
    return cannot_step_mechanisms(scheme, "it keeps the energy of constant masses, and theirs depend on coordinates");
  RigidModel<S>& model = *request.model;
  if (const std::string& why = model.conservative().refusal(); !why.empty())
    return Fault{scheme + " needs an energy to keep: " + why};
  const bool compensated = request.flag("compensated");
  if (scheme == "average-vector-field")
    return StepperPointer<S>(std::make_unique<Gradient>(model, Gradient::Force::mean_over_segment, compensated));
  if (scheme == "discrete-gradient")
    return StepperPointer<S>(std::make_unique<Gradient>(model, Gradient::Force::discrete_gradient, compensated));
  if (scheme == "projected-rk4") return StepperPointer<S>(std::make_unique<ProjectedRungeKutta<S>>(model, compensated));
  return StepperPointer<S>(std::make_unique<RelaxationRungeKutta<S>>(model, compensated));
}

template StepperResult<float> make_conserving(const StepperRequest<float>&);
template StepperResult<double> make_conserving(const StepperRequest<double>&);
template StepperResult<long double> make_conserving(const StepperRequest<long double>&);
template StepperResult<Quad> make_conserving(const StepperRequest<Quad>&);

}  // namespace atwood
