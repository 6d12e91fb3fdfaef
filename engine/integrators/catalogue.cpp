#include "integrators/catalogue.hpp"

#include "integrators/adaptive.hpp"
#include "integrators/implicit_euler.hpp"
#include "integrators/partitioned.hpp"
#include "integrators/runge_kutta.hpp"
#include "integrators/tableaux.hpp"

namespace atwood {
namespace {

std::map<std::string, double> claims(double order) {
  return {{"point-mass", order}, {"velocity-dependent", order}, {"rotation", order}};
}

const std::string embedded =
    " A rotating body's quaternion is integrated as four numbers, q' = 1/2 q (0, w), beside Euler's equations in body "
    "axes, "
    "and normalised after each step, so that attitude keeps the order.";

MethodInfo fixed_step(const std::string& scheme, double order, const std::string& doc, const std::string& source) {
  return {"atwood/" + scheme, doc, source, claims(order), false, {{"scalar", std::string("double")}}};
}

MethodInfo pair_of_orders(const std::string& scheme, double order, const std::string& doc, const std::string& source) {
  Settings settings{{"scalar", std::string("double")},       {"atol_over_rtol", 0.01},
                    {"safety", StepControl<double>::safety}, {"beta", StepControl<double>::beta},
                    {"least_factor", StepControl<double>::least}, {"most_factor", StepControl<double>::most}};
  return {"atwood/" + scheme, doc, source, claims(order), true, settings};
}

std::vector<MethodInfo> euler_methods() {
  return {
      fixed_step(
          "explicit-euler", 1, "y_new = y + h f(t, y): p_new = p + h v, v_new = v + h a(t, p, v)." + embedded,
          "Euler, Institutionum calculi integralis I (1768), section 650; Hairer, Norsett, Wanner, Solving ODEs I, "
          "eq. I.7.3"),
      fixed_step(
          "symplectic-euler", 1,
          "Velocities first, from forces at the old state; then positions with the new velocities: "
          "v_new = v + h a(t, p, v), p_new = p + h v_new. A rotating body: w += h I^-1 torque (without w x I w), "
          "then the free top by rotations about its principal axes 1, 2, 3, each by h L_i / I_i.",
          "Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), eq. I.1.9 (the variant that updates "
          "velocities first)"),
      fixed_step("implicit-euler", 1,
                 "y_new = y + h f(t + h, y_new), solved to round-off by fixed-point sweeps, or by simplified Newton "
                 "iteration where they contract slowly." +
                     embedded,
                 "Hairer, Wanner, Solving ODEs II (2nd ed.), eq. IV.1.8")};
}

std::vector<MethodInfo> runge_kutta_methods() {
  return {
      fixed_step("midpoint", 2, "Explicit midpoint: k1 = f(t, y), y_new = y + h f(t + h/2, y + h/2 k1)." + embedded,
                 "Runge, Math. Ann. 46 (1895) 167; Hairer, Norsett, Wanner I, eq. II.1.4"),
      fixed_step("heun", 2,
                 "Trapezoidal Heun: k1 = f(t, y), k2 = f(t + h, y + h k1), y_new = y + h (k1 + k2) / 2." + embedded,
                 "Heun, Z. Math. Phys. 45 (1900) 23; Hairer, Norsett, Wanner I, table II.1.1"),
      fixed_step("rk4", 4, "The classical Runge-Kutta method, weights 1/6 1/3 1/3 1/6." + embedded,
                 "Kutta, Z. Math. Phys. 46 (1901) 435; Hairer, Norsett, Wanner I, table II.1.2"),
      pair_of_orders("rkf45", 4,
                     "Fehlberg's pair: the order-4 result advances, the order-5 one judges the step. Without a "
                     "tolerance: equal steps. With one: PI step control; samples by a shorter step of the same "
                     "method." +
                         embedded,
                     "Fehlberg, NASA TR R-315 (1969), table III; Hairer, Norsett, Wanner I, table II.5.1"),
      pair_of_orders("dopri5", 5,
                     "Dormand and Prince's pair of orders 5 and 4, seven stages, the last shared with the next step; "
                     "the order-5 result advances. Without a tolerance: equal steps. With one: PI step control, "
                     "samples by its own interpolant of order 4." +
                         embedded,
                     "Dormand, Prince, J. Comput. Appl. Math. 6 (1980) 19, table 2; Hairer, Norsett, Wanner I, table "
                     "II.5.2 and eq. II.6.12")};
}

std::vector<MethodInfo> verlet_methods() {
  const std::string rest =
      " A rotating body's drift is the symmetric splitting of the free top, rotations about its principal axes 1 2 3 2 "
      "1 by "
      "h/2 h/2 h h/2 h/2 of L_i / I_i. Where a force depends on velocities, a kick is the implicit midpoint rule in "
      "the velocities, solved to round-off (Boris's rotation for a magnetic field), which keeps order 2.";
  return {
      fixed_step(
          "velocity-verlet", 2,
          "Kick, drift, kick: v_half = v + h/2 a(t, p), p_new = p + h v_half, v_new = v_half + h/2 a(t + h, p_new)." +
              rest,
          "Swope, Andersen, Berens, Wilson, J. Chem. Phys. 76 (1982) 637, eq. 4-5; Hairer, Lubich, Wanner, "
          "Geometric Numerical Integration (2nd ed.), eq. I.1.17; rotation: Dullweber, Leimkuhler, McLachlan, J. "
          "Chem. Phys. 107 (1997) 5840"),
      fixed_step(
          "leapfrog", 2,
          "Drift, kick, drift (position Verlet): p_half = p + h/2 v, v_new = v + h a(t + h/2, p_half), p_new = p_half "
          "+ h/2 v_new." +
              rest,
          "Tuckerman, Berne, Martyna, J. Chem. Phys. 97 (1992) 1990, eq. 2.22; Boris, Proc. 4th Conf. Numer. Simul. "
          "Plasmas (1970) 3")};
}

std::vector<MethodInfo> build_catalogue() {
  std::vector<MethodInfo> all;
  for (const auto& family : {euler_methods(), runge_kutta_methods(), verlet_methods()})
    all.insert(all.end(), family.begin(), family.end());
  return all;
}

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

const std::vector<MethodInfo>& integrator_catalogue() {
  static const std::vector<MethodInfo> all = build_catalogue();
  return all;
}

const MethodInfo* find_integrator(const std::string& scheme) {
  for (const MethodInfo& info : integrator_catalogue())
    if (info.id == "atwood/" + scheme) return &info;
  return nullptr;
}

template <class S>
std::unique_ptr<Stepper<S>> make_stepper(const std::string& scheme, RigidModel<S>& model, std::string& why) {
  if (const Tableau* tableau = find_tableau(scheme))
    return std::make_unique<ExplicitRungeKutta<S>>(model.system(), *tableau);
  if (scheme == "implicit-euler") return std::make_unique<ImplicitEuler<S>>(model.system());
  if (model.bare_problem()) {
    why = "atwood/" + scheme + " needs positions and velocities; this problem is a bare system of equations";
    return nullptr;
  }
  if (scheme == "symplectic-euler") return std::make_unique<SymplecticEuler<S>>(model);
  if (scheme == "velocity-verlet") return std::make_unique<VelocityVerlet<S>>(model);
  if (scheme == "leapfrog") return std::make_unique<Leapfrog<S>>(model);
  why = "atwood has no method `" + scheme + "`";
  return nullptr;
}

template std::unique_ptr<Stepper<float>> make_stepper(const std::string&, RigidModel<float>&, std::string&);
template std::unique_ptr<Stepper<double>> make_stepper(const std::string&, RigidModel<double>&, std::string&);
template std::unique_ptr<Stepper<long double>> make_stepper(const std::string&, RigidModel<long double>&, std::string&);
template std::unique_ptr<Stepper<Quad>> make_stepper(const std::string&, RigidModel<Quad>&, std::string&);

}  // namespace atwood
