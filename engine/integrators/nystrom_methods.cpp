// Runge-Kutta-Nystrom methods: their ids, documentation and steppers.
#include "integrators/families.hpp"
#include "integrators/nystrom.hpp"

namespace atwood {
namespace {

const std::string where =
    " For x'' = a(t, x) alone: points under forces of time and position. Forces of velocity, bodies that rotate and "
    "bare problems are refused.";
const std::string pair =
    " Without a tolerance: equal steps. With one: PI step control on positions and velocities, samples by a shorter "
    "step of the same method.";

std::map<std::string, double> points(double order) { return {{"point-mass", order}}; }

template <class S> std::string why_not(const RigidModel<S>& model) {
  if (model.velocity_dependent()) return "needs x'' = a(t, x); here a force depends on velocity";
  for (int i = 0; i < model.body_count(); ++i)
    if (model.offset(i) >= 0 && model.rotates(i)) return "moves points only; here a body rotates";
  return "";
}

}  // namespace

std::vector<MethodInfo> nystrom_methods() {
  return {
      with_tolerance(
          "dprkn6", points(6),
          "Runge-Kutta-Nystrom pair of orders 6 and 4, RKN6(4)6FM: x_new = x + h v + h^2 sum b_i k_i, "
          "v_new = v + h sum b'_i k_i. 6 stages, the last shared with the next step: 5 evaluations per step." +
              pair + where,
          "Dormand, El-Mikkawy, Prince, IMA J. Numer. Anal. 7 (1987) 235"),
      with_tolerance(
          "dprkn12", points(12),
          "Runge-Kutta-Nystrom pair of orders 12 and 10, RKN12(10)17M. 17 stages, as many evaluations per step." +
              pair + where,
          "Dormand, El-Mikkawy, Prince, IMA J. Numer. Anal. 7 (1987) 423; Brankin, Gladwell, Dormand, Prince, "
          "Seward, ACM Trans. Math. Softw. 15 (1989) 31, algorithm 670"),
      fixed_step(
          "blanes-moan-rkn4", points(4),
          "Symplectic and symmetric Runge-Kutta-Nystrom method SRKN_6^b: seven kicks with six drifts between them, "
          "the last kick's acceleration shared with the next step: 6 evaluations per step." +
              where,
          "Blanes, Moan, J. Comput. Appl. Math. 142 (2002) 313, table 3"),
      fixed_step(
          "blanes-moan-rkn6", points(6),
          "Symplectic and symmetric Runge-Kutta-Nystrom method SRKN_14^a: fifteen drifts with fourteen kicks between "
          "them, 14 evaluations per step." +
              where,
          "Blanes, Moan, J. Comput. Appl. Math. 142 (2002) 313, table 3")};
}

template <class S> StepperResult<S> make_nystrom(const StepperRequest<S>& request) {
  const std::string& scheme = request.scheme;
  const bool pairs = scheme == "dprkn6" || scheme == "dprkn12";
  if (!pairs && scheme != "blanes-moan-rkn4" && scheme != "blanes-moan-rkn6") return StepperPointer<S>{};
  if (without_bodies(request)) return cannot_step_bare(scheme, "needs positions and velocities");
  if (has_mechanisms(request))
    return cannot_step_mechanisms(scheme, "it needs x'' = a(t, x), and their accelerations depend on rates");
  RigidModel<S>& model = *request.model;
  if (const std::string why = why_not(model); !why.empty()) return cannot_step(scheme, why);
  const bool compensated = request.flag("compensated");
  if (pairs)
    return StepperPointer<S>(std::make_unique<Nystrom<S>>(
        model, scheme == "dprkn6" ? dormand_prince_nystrom6 : dormand_prince_nystrom12, compensated));
  return StepperPointer<S>(std::make_unique<SymplecticNystrom<S>>(
      model, scheme == "blanes-moan-rkn4" ? blanes_moan_nystrom4 : blanes_moan_nystrom6, compensated));
}

template StepperResult<float> make_nystrom(const StepperRequest<float>&);
template StepperResult<double> make_nystrom(const StepperRequest<double>&);
template StepperResult<long double> make_nystrom(const StepperRequest<long double>&);
template StepperResult<Quad> make_nystrom(const StepperRequest<Quad>&);

}  // namespace atwood
