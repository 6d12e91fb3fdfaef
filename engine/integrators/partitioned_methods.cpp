// Methods that move positions and velocities in turns: their ids, documentation and steppers.
#include "integrators/partitioned.hpp"

namespace atwood {
namespace {

struct Named {
  const char* scheme;
  const char* composition;
};
const Named all[] = {{"symplectic-euler", "symplectic-euler"},
                     {"velocity-verlet", "leapfrog-kdk"},
                     {"leapfrog", "leapfrog-dkd"},
                     {"leapfrog-kdk", "leapfrog-kdk"},
                     {"leapfrog-dkd", "leapfrog-dkd"}};

}  // namespace

std::vector<MethodInfo> partitioned_methods() {
  const std::string rotation_and_velocity =
      " A rotating body's drift is the symmetric splitting of the free top into rotations about its principal axes "
      "by L_i / I_i. Where a force depends on velocities, a kick is the implicit midpoint rule in the velocities, "
      "solved to round-off (Boris's rotation for a magnetic field), which keeps order 2.";
  const std::string kdk =
      "v_half = v + h/2 a(t, p), p_new = p + h v_half, v_new = v_half + h/2 a(t + h, p_new)." + rotation_and_velocity;
  const std::string dkd =
      "p_half = p + h/2 v, v_new = v + h a(t + h/2, p_half), p_new = p_half + h/2 v_new." + rotation_and_velocity;
  const std::string rotation = "; rotation: Dullweber, Leimkuhler, McLachlan, J. Chem. Phys. 107 (1997) 5840";
  const std::string verlet =
      "Swope, Andersen, Berens, Wilson, J. Chem. Phys. 76 (1982) 637, eq. 4-5; Hairer, Lubich, Wanner, Geometric "
      "Numerical Integration (2nd ed.), eq. I.1.17" +
      rotation;
  const std::string position_verlet =
      "Tuckerman, Berne, Martyna, J. Chem. Phys. 97 (1992) 1990, eq. 2.22; Boris, Proc. 4th Conf. Numer. Simul. "
      "Plasmas (1970) 3" +
      rotation;
  return {
      fixed_step(
          "symplectic-euler", claims_everywhere(1),
          "Velocities first, from forces at the old state; then positions with the new velocities: v_new = v + h "
          "a(t, p, v), p_new = p + h v_new. A rotating body: w += h I^-1 torque (without w x I w), then the free top "
          "by rotations about its principal axes 1, 2, 3, each by h L_i / I_i.",
          "Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), eq. I.1.9 (the variant that updates "
          "velocities first)"),
      fixed_step("velocity-verlet", claims_everywhere(2), "Kick, drift, kick: " + kdk, verlet),
      fixed_step("leapfrog", claims_everywhere(2), "Drift, kick, drift (position Verlet): " + dkd, position_verlet),
      fixed_step("leapfrog-kdk", claims_everywhere(2),
                 "Velocity Verlet under its other name. Kick, drift, kick: " + kdk, verlet),
      fixed_step("leapfrog-dkd", claims_everywhere(2), "Leapfrog under its full name. Drift, kick, drift: " + dkd,
                 position_verlet)};
}

template <class S> StepperResult<S> make_partitioned(const StepperRequest<S>& request) {
  for (const auto& [scheme, composition] : all)
    if (request.scheme == scheme) return make_kick_drift(request, composition);
  return StepperPointer<S>{};
}

template StepperResult<float> make_partitioned(const StepperRequest<float>&);
template StepperResult<double> make_partitioned(const StepperRequest<double>&);
template StepperResult<long double> make_partitioned(const StepperRequest<long double>&);
template StepperResult<Quad> make_partitioned(const StepperRequest<Quad>&);

}  // namespace atwood
