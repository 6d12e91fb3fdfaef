// Implicit one-step methods: their ids, documentation and steppers.
#include "integrators/families.hpp"
#include "integrators/implicit_alpha.hpp"
#include "integrators/implicit_runge_kutta.hpp"
#include "integrators/implicit_tableaux.hpp"
#include "integrators/symmetric_projection.hpp"

namespace atwood {
namespace {

const std::string solved_how =
    " Stage equations are solved to the round-off of the scalar, by sweeps where they contract fast, else by "
    "simplified Newton iteration on the same equations: its Jacobian, by differences, affects only the convergence, so "
    "the solver has no tolerance that could enter the order.";
const std::string gauss_attitude =
    " A rotating body's quaternion is integrated as four numbers, q' = 1/2 q (0, w), beside Euler's equations in "
    "body axes; its length is a quadratic invariant, which the method keeps to round-off with no projection.";
const std::string symmetric_on_loops =
    " On loops and ropes the symmetric projection keeps the order and the reversibility; quadratic invariants are kept "
    "only without it.";

MethodInfo gauss(const std::string& scheme, int stages, const std::string& name) {
  const int order = 2 * stages;
  MethodInfo info = fixed_step(
      scheme, claims_in_any_coordinates(order),
      name + ": collocation at the zeros of Legendre's polynomial of degree " + std::to_string(stages) + ", of order " +
          std::to_string(order) +
          "; reversible, A-stable without damping at infinity; conserves quadratic invariants; symplectic where positions "
          "and momenta are the state: points, not mechanisms in joint coordinates and rates (q, u), whose momenta are "
          "p = M(q) u." +
          solved_how + gauss_attitude + symmetric_on_loops,
      "Butcher, Math. Comp. 18 (1964) 50; Hairer, Wanner, Solving ODEs II (2nd ed.), section IV.5; Hairer, Lubich, "
      "Wanner, Geometric Numerical Integration (2nd ed.), V.4.1 and VIII.6");
  declare_settings(
      info,
      {{"projection",
        std::string("symmetric"),
        {one_of({"symmetric", "standard", "none"}),
         "Mechanisms with loops or ropes: the same multipliers move the state before and after a step so that it ends on "
         "the constraints (symmetric; several solves a step); or positions and rates are projected onto the constraints "
         "after a step, which then is not symmetric (standard); or they are not and drift (none)."}}});
  return info;
}

// Its default is the ordinary projection: the symmetric one takes several solves a step.
MethodInfo trapezoid() {
  MethodInfo info = fixed_step(
      "trapezoid", claims_in_any_coordinates(2),
      "y_new = y + h/2 (f(t, y) + f(t + h, y_new)); A-stable without damping at infinity. Reversible where "
      "nothing is normalised or projected after a step: not with quaternions, and on loops and ropes only with "
      "the symmetric projection (projection=symmetric), which needs a state without quaternions." +
          solved_how + embedded_attitude,
      "Dahlquist, BIT 3 (1963) 27; Hairer, Norsett, Wanner, Solving ODEs I (2nd ed.), eq. II.7.4");
  declare_settings(
      info,
      {{"projection",
        std::string("standard"),
        {one_of({"standard", "symmetric", "none"}),
         "Mechanisms with loops or ropes: positions and rates are projected onto the constraints after a step, which "
         "then is not symmetric (standard); or the same multipliers move the state before and after a step so "
         "that it ends on them (symmetric; several solves a step); or they are not and drift (none)."}}});
  return info;
}

MethodInfo generalised_alpha() {
  MethodInfo info =
      fixed_step("generalised-alpha", claims_in_any_coordinates(2),
                 "The equations of motion hold at t + h / (1 + rho): positions and velocities by the second-order "
                 "form, attitudes and body rates by the first-order one. rho_infinity, in [0, 1], is "
                 "the spectral radius for infinitely stiff components: 1 keeps them, 0 removes them in "
                 "one step." +
                     solved_how,
                 "Chung, Hulbert, J. Appl. Mech. 60 (1993) 371, eq. 17, 20 and 25; Jansen, Whiting, "
                 "Hulbert, Comput. Methods Appl. Mech. Eng. 190 (2000) 305, eq. 19 and 24");
  declare_settings(info, {{"rho_infinity", 0.8, {between(0, 1), "Spectral radius for infinitely stiff components."}}});
  return info;
}

}  // namespace

std::vector<MethodInfo> implicit_methods() {
  return {
      fixed_step("implicit-euler", claims_in_any_coordinates(1),
                 "y_new = y + h f(t + h, y_new); L-stable." + solved_how + embedded_attitude,
                 "Hairer, Wanner, Solving ODEs II (2nd ed.), eq. IV.1.8"),
      trapezoid(),
      gauss("implicit-midpoint", 1, "y_new = y + h f(t + h/2, (y + y_new) / 2), the implicit midpoint rule"),
      gauss("gauss2", 1, "Gauss's method of one stage, the implicit midpoint rule"),
      gauss("gauss4", 2, "Gauss's method of two stages (Hammer and Hollingsworth)"),
      gauss("gauss6", 3, "Gauss's method of three stages (Kuntzmann and Butcher)"),
      gauss("gauss8", 4, "Gauss's method of four stages (Kuntzmann and Butcher)"),
      with_tolerance(
          "radau5", claims_in_any_coordinates(5),
          "Radau IIA of three stages: collocation with c_3 = 1, of order 5, L-stable. Without a tolerance: equal "
          "steps. With one: PI step control by the embedded estimate of order 3, filtered where the system is stiff; "
          "samples by a shorter step of the same method." +
              solved_how + embedded_attitude,
          "Hairer, Wanner, Solving ODEs II (2nd ed.), table IV.5.6 and section IV.8"),
      fixed_step("sdirk2", claims_in_any_coordinates(2),
                 "Singly diagonally implicit, two stages, gamma = 1 - 1/sqrt 2, order 2, L-stable." + solved_how +
                     embedded_attitude,
                 "Alexander, SIAM J. Numer. Anal. 14 (1977) 1006, theorem 5"),
      fixed_step(
          "sdirk4", claims_in_any_coordinates(4),
          "Singly diagonally implicit, five stages, gamma = 1/4, order 4, L-stable." + solved_how + embedded_attitude,
          "Hairer, Wanner, Solving ODEs II (2nd ed.), table IV.6.5"),
      generalised_alpha()};
}

template <class S> StepperResult<S> make_implicit(const StepperRequest<S>& request) {
  const std::string& scheme = request.scheme;
  const bool constrained = request.model != nullptr && request.model->constraints() != nullptr;
  const auto runge_kutta = [&](const CollocationTableau& tableau, bool projects, bool estimates = false) {
    const ImplicitOptions options{request.flag("compensated"), projects, estimates};
    return StepperPointer<S>(std::make_unique<ImplicitRungeKutta<S>>(request.system, tableau, options));
  };
  const auto asks_symmetric = [&] {
    return constrained && std::get<std::string>(request.settings.at("projection")) == "symmetric";
  };
  const auto symmetric = [&](const CollocationTableau& tableau) -> StepperResult<S> {
    if (request.flag("compensated"))
      return cannot_step(scheme, "takes either compensated sums or the symmetric projection of loops and ropes");
    return StepperPointer<S>(std::make_unique<SymmetricProjection<S>>(*request.model, runge_kutta(tableau, false)));
  };
  const auto gauss = [&](int stages) -> StepperResult<S> {
    const CollocationTableau tableau = gauss_collocation(stages);
    return asks_symmetric() ? symmetric(tableau) : runge_kutta(tableau, constrained);
  };
  if (scheme == "implicit-euler") return runge_kutta(radau_right_collocation(1), true);
  if (scheme == "trapezoid" && asks_symmetric()) {
    // Gauss's methods keep the length of a quaternion; here it would have to be one of the constraints.
    if (!request.model->attitudes().empty())
      return cannot_step(scheme,
                         "projects symmetrically onto loops and ropes of states without quaternions: of hinges, "
                         "sliders and points; expected projection=standard here");
    return symmetric(trapezoid_tableau());
  }
  if (scheme == "trapezoid") return runge_kutta(trapezoid_tableau(), true);
  if (scheme == "implicit-midpoint" || scheme == "gauss2") return gauss(1);
  if (scheme == "gauss4") return gauss(2);
  if (scheme == "gauss6") return gauss(3);
  if (scheme == "gauss8") return gauss(4);
  if (scheme == "radau5") return runge_kutta(radau_right_collocation(3), true, true);
  if (scheme == "sdirk2") return runge_kutta(sdirk2_tableau(), true);
  if (scheme == "sdirk4") return runge_kutta(sdirk4_tableau(), true);
  if (scheme != "generalised-alpha") return StepperPointer<S>{};
  return StepperPointer<S>(std::make_unique<GeneralisedAlpha<S>>(
      request.system, request.model, S(request.number("rho_infinity")), request.flag("compensated")));
}

template StepperResult<float> make_implicit(const StepperRequest<float>&);
template StepperResult<double> make_implicit(const StepperRequest<double>&);
template StepperResult<long double> make_implicit(const StepperRequest<long double>&);
template StepperResult<Quad> make_implicit(const StepperRequest<Quad>&);

}  // namespace atwood
