// Compositions of kicks and drifts: their ids, documentation and steppers.
#include "integrators/partitioned.hpp"

namespace atwood {
namespace {

const std::string kicks_and_drifts =
    " Kicks and drifts are taken alternately from a map of order 1 and from its adjoint, so that a rotating body "
    "(rotations about its principal axes) and forces that depend on velocities (Euler's rule in the velocities, "
    "explicit and implicit, in closed form for a magnetic field) keep the order.";
const std::string leapfrogs =
    " A symmetric sequence of leapfrog steps (drift, kick, drift) of different lengths, so that a rotating body "
    "(symmetric splitting of the free top) and forces that depend on velocities (kicks by the implicit midpoint "
    "rule, Boris's rotation in a magnetic field) keep the order.";
const std::string suzuki_source = "Suzuki, Phys. Lett. A 146 (1990) 319; J. Math. Phys. 32 (1991) 400";
const std::string yoshida_source = "Yoshida, Phys. Lett. A 150 (1990) 262, ";
const std::string blanes_moan_source = "Blanes, Moan, J. Comput. Appl. Math. 142 (2002) 313, table 2, ";
const std::string rotation_source = "; Birdsall, Langdon, Plasma Physics via Computer Simulation (1985), section 4-3";
const std::string boris =
    "Boris's push of charges: drift h/2; kick, half the electric force, the velocity turned by the magnetic field, "
    "the other half; drift h/2. The turn is Cayley's (the vector h q B / 2 m for the tangent of half the angle), the "
    "implicit midpoint rule in closed form: |v| is kept without an electric field. Other forces may depend on "
    "positions and time only.";

struct Charges {
  const char* scheme;
  const char* composition;
};
const Charges charges[] = {{"boris", "leapfrog-dkd"}, {"boris4", "suzuki4"}, {"boris6", "kahan-li6"}};

}  // namespace

std::vector<MethodInfo> composition_methods() {
  return {
      fixed_step("forest-ruth", claims_everywhere(4),
                 "Three kicks between four drifts, drifts first; theta = 1 / (2 - 2^(1/3))." + kicks_and_drifts,
                 "Forest, Ruth, Physica D 43 (1990) 105"),
      fixed_step(
          "pefrl", claims_everywhere(4),
          "Four kicks between five drifts (position extended Forest-Ruth like), its free parameter chosen for the "
          "least error." +
              kicks_and_drifts,
          "Omelyan, Mryglod, Folk, Comput. Phys. Commun. 146 (2002) 188"),
      fixed_step(
          "mclachlan4", claims_everywhere(4),
          "Five kicks, coefficients in closed form with sqrt(19)." + kicks_and_drifts,
          "McLachlan, SIAM J. Sci. Comput. 16 (1995) 151; Hairer, Lubich, Wanner, Geometric Numerical Integration "
          "(2nd ed.), eq. V.3.6"),
      fixed_step("suzuki4", claims_everywhere(4), "Suzuki's fractal, 5 steps; g = 1 / (4 - 4^(1/3))." + leapfrogs,
                 suzuki_source),
      fixed_step("suzuki6", claims_everywhere(6), "Suzuki's fractal, 25 steps." + leapfrogs, suzuki_source),
      fixed_step("suzuki8", claims_everywhere(8), "Suzuki's fractal, 125 steps." + leapfrogs, suzuki_source),
      fixed_step(
          "yoshida4", claims_everywhere(4),
          "The triple jump, kicks first: four kicks, the last one shared with the next step, between three drifts." +
              kicks_and_drifts,
          yoshida_source + "section 2"),
      fixed_step("yoshida6", claims_everywhere(6), "7 steps, solution A." + leapfrogs, yoshida_source + "table 1"),
      fixed_step("yoshida8", claims_everywhere(8), "15 steps, solution D." + leapfrogs, yoshida_source + "table 2"),
      fixed_step("blanes-moan4", claims_everywhere(4),
                 "Blanes and Moan's S6, drifts first: six kicks." + kicks_and_drifts, blanes_moan_source + "S6"),
      fixed_step("blanes-moan6", claims_everywhere(6),
                 "Blanes and Moan's S10, kicks first: eleven kicks, the last one shared with the next step." +
                     kicks_and_drifts,
                 blanes_moan_source + "S10"),
      fixed_step("kahan-li8", claims_everywhere(8), "17 steps." + leapfrogs,
                 "Kahan, Li, Math. Comput. 66 (1997) 1089, s17odr8a"),
      fixed_step("boris", claims_everywhere(2), boris,
                 "Boris, Proc. 4th Conf. Numer. Simul. Plasmas (1970) 3" + rotation_source),
      fixed_step("boris4", claims_everywhere(4), "Suzuki's composition of five steps. " + boris,
                 suzuki_source + rotation_source),
      fixed_step("boris6", claims_everywhere(6), "Kahan and Li's composition of nine steps. " + boris,
                 "Kahan, Li, Math. Comput. 66 (1997) 1089, s9odr6a" + rotation_source)};
}

template <class S> StepperResult<S> make_composition(const StepperRequest<S>& request) {
  for (const auto& [scheme, composition] : charges) {
    if (request.scheme != scheme) continue;
    if (!without_bodies(request) && !has_mechanisms(request) && !request.model->magnetic_only())
      return cannot_step(
          request.scheme,
          "turns velocities by magnetic fields; a force of this scene depends on velocities in another way");
    return make_kick_drift(request, composition);
  }
  for (const MethodInfo& info : composition_methods())
    if (info.id == "atwood/" + request.scheme) return make_kick_drift(request, request.scheme);
  return StepperPointer<S>{};
}

template StepperResult<float> make_composition(const StepperRequest<float>&);
template StepperResult<double> make_composition(const StepperRequest<double>&);
template StepperResult<long double> make_composition(const StepperRequest<long double>&);
template StepperResult<Quad> make_composition(const StepperRequest<Quad>&);

}  // namespace atwood
