// Explicit Runge-Kutta methods: what they are called and which tableau each runs.
#include "integrators/families.hpp"
#include "integrators/runge_kutta.hpp"
#include "integrators/tableaux.hpp"

namespace atwood {
namespace {

const Tableau* find_tableau(const std::string& scheme) {
  if (scheme == "explicit-euler") return &explicit_euler_tableau;
  if (scheme == "midpoint") return &midpoint_tableau;
  if (scheme == "heun") return &heun_tableau;
  if (scheme == "rk4") return &rk4_tableau;
  if (scheme == "rkf45") return &fehlberg45_tableau;
  if (scheme == "dopri5") return &dormand_prince5_tableau;
  return nullptr;
}

}  // namespace

std::vector<MethodInfo> explicit_runge_kutta_methods() {
  return {
      fixed_step("explicit-euler", claims_everywhere(1), "y_new = y + h f(t, y): p_new = p + h v, v_new = v + h a(t, p, v)." + embedded_attitude,
          "Euler, Institutionum calculi integralis I (1768), section 650; Hairer, Norsett, Wanner, Solving ODEs I, "
          "eq. I.7.3"),
      fixed_step("midpoint", claims_everywhere(2), "Explicit midpoint: k1 = f(t, y), y_new = y + h f(t + h/2, y + h/2 k1)." + embedded_attitude,
                 "Runge, Math. Ann. 46 (1895) 167; Hairer, Norsett, Wanner I, eq. II.1.4"),
      fixed_step("heun", claims_everywhere(2),
                 "Trapezoidal Heun: k1 = f(t, y), k2 = f(t + h, y + h k1), y_new = y + h (k1 + k2) / 2." + embedded_attitude,
                 "Heun, Z. Math. Phys. 45 (1900) 23; Hairer, Norsett, Wanner I, table II.1.1"),
      fixed_step("rk4", claims_everywhere(4), "The classical Runge-Kutta method, weights 1/6 1/3 1/3 1/6." + embedded_attitude,
                 "Kutta, Z. Math. Phys. 46 (1901) 435; Hairer, Norsett, Wanner I, table II.1.2"),
      with_tolerance("rkf45", claims_everywhere(4),
                     "Fehlberg's pair: the order-4 result advances, the order-5 one judges the step. Without a "
                     "tolerance: equal steps. With one: PI step control; samples by a shorter step of the same "
                     "method." +
                         embedded_attitude,
                     "Fehlberg, NASA TR R-315 (1969), table III; Hairer, Norsett, Wanner I, table II.5.1"),
      with_tolerance("dopri5", claims_everywhere(5),
                     "Dormand and Prince's pair of orders 5 and 4, seven stages, the last shared with the next step; "
                     "the order-5 result advances. Without a tolerance: equal steps. With one: PI step control, "
                     "samples by its own interpolant of order 4." +
                         embedded_attitude,
                     "Dormand, Prince, J. Comput. Appl. Math. 6 (1980) 19, table 2; Hairer, Norsett, Wanner I, table "
                     "II.5.2 and eq. II.6.12")};
}

template <class S> StepperPointer<S> make_explicit_runge_kutta(StepperRequest<S>& request) {
  const Tableau* tableau = find_tableau(request.scheme);
  if (tableau == nullptr) return nullptr;
  return std::make_unique<ExplicitRungeKutta<S>>(request.model.system(), *tableau);
}

template StepperPointer<float> make_explicit_runge_kutta(StepperRequest<float>&);
template StepperPointer<double> make_explicit_runge_kutta(StepperRequest<double>&);
template StepperPointer<long double> make_explicit_runge_kutta(StepperRequest<long double>&);
template StepperPointer<Quad> make_explicit_runge_kutta(StepperRequest<Quad>&);

}  // namespace atwood
