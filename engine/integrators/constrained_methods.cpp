// Contrast methods for mechanisms in maximal coordinates: their ids, documentation and steppers.
#include "integrators/compositions.hpp"
#include "integrators/families.hpp"
#include "integrators/maximal_coordinates.hpp"

namespace atwood {
namespace {

const std::string maximal =
    " Every body is free, every joint a constraint. Forces may depend on positions and time only; no prescribed motion, "
    "limits, forces along joints or heavy pulleys. Reactions are computed from the state, not from the multipliers of "
    "the step, which are less accurate.";
const std::string rattle_source =
    "Andersen, J. Comput. Phys. 52 (1983) 24; Jay, SIAM J. Numer. Anal. 33 (1996) 368; Hairer, Lubich, Wanner, Geometric "
    "Numerical Integration (2nd ed.), VII.1.4";

MethodInfo baumgarte() {
  MethodInfo info = fixed_step(
      "baumgarte", {{"mechanism", 1}},
      "Semi-implicit Euler on velocities, corrected by impulses so that each constraint's rate is -erp / h times its "
      "violation, as game engines do; then positions with the new velocities." +
          maximal,
      "Baumgarte, Comput. Methods Appl. Mech. Eng. 1 (1972) 1; Catto, Iterative Dynamics with Temporal Coherence, GDC "
      "2005");
  declare_settings(info, {{"erp", 0.2, {between(0, 1), "Part of a constraint's violation that a step takes away."}}});
  return info;
}

// What each leapfrog of a composition takes of a step.
template <class S> std::vector<S> fractions_of(const char* composition) {
  std::vector<S> fractions;
  for (const Substep& substep : find_composition(composition)->substeps())
    if (substep.kick) fractions.push_back(S(substep.direct + substep.adjoint));
  return fractions;
}

}  // namespace

bool steps_maximal_coordinates(const std::string& scheme) {
  return scheme == "rattle" || scheme == "rattle4" || scheme == "rattle6" || scheme == "baumgarte";
}

std::vector<MethodInfo> constrained_methods() {
  return {
      fixed_step("rattle", {{"mechanism", 2}, {"loop", 2}},
                 "RATTLE: half a kick and impulses of the constraints so that they hold at the end of the free motion "
                 "that follows, exact for rotating bodies; half a kick and impulses so that their rates are 0. "
                 "Symmetric, symplectic." +
                     maximal,
                 rattle_source),
      fixed_step("rattle4", {{"mechanism", 4}, {"loop", 4}},
                 "Suzuki's symmetric composition of five steps of RATTLE." + maximal,
                 rattle_source + "; Suzuki, Phys. Lett. A 146 (1990) 319"),
      fixed_step("rattle6", {{"mechanism", 6}, {"loop", 6}},
                 "Kahan and Li's symmetric composition of nine steps of RATTLE." + maximal,
                 rattle_source + "; Kahan, Li, Math. Comput. 66 (1997) 1089, s9odr6a"),
      baumgarte()};
}

template <class S> StepperResult<S> make_constrained(const StepperRequest<S>& request) {
  const std::string& scheme = request.scheme;
  if (!steps_maximal_coordinates(scheme)) return StepperPointer<S>{};
  if (without_bodies(request)) return cannot_step_bare(scheme, "steps mechanisms");
  if (!has_mechanisms(request) || request.model->constraints() == nullptr)
    return cannot_step(scheme, "steps mechanisms; the scene has neither joints nor ropes");
  if (request.model->forces_depend_on_velocities())
    return cannot_step(scheme, "takes forces that depend on positions and time only");
  if (scheme == "baumgarte")
    return StepperPointer<S>(std::make_unique<BaumgarteEuler<S>>(*request.model, S(request.number("erp"))));
  const std::vector<S> fractions = scheme == "rattle"    ? std::vector<S>{S(1)}
                                   : scheme == "rattle4" ? fractions_of<S>("suzuki4")
                                                         : fractions_of<S>("kahan-li6");
  return StepperPointer<S>(std::make_unique<Rattle<S>>(*request.model, fractions));
}

template StepperResult<float> make_constrained(const StepperRequest<float>&);
template StepperResult<double> make_constrained(const StepperRequest<double>&);
template StepperResult<long double> make_constrained(const StepperRequest<long double>&);
template StepperResult<Quad> make_constrained(const StepperRequest<Quad>&);

}  // namespace atwood
