// Multistep methods: their ids, documentation and steppers.
#include "integrators/families.hpp"
#include "integrators/implicit_runge_kutta.hpp"
#include "integrators/multistep.hpp"

namespace atwood {
namespace {

enum class Kind { none, bashforth, moulton, backward };
struct Choice {
  Kind kind;
  int order;
};

constexpr int kHighestAdams = 8, kHighestBdf = 5;

// "adams-bashforth4": the number is the order.
Choice chosen(const std::string& scheme) {
  if (scheme.empty() || scheme.back() < '1' || scheme.back() > '9') return {Kind::none, 0};
  const int order = scheme.back() - '0';
  const std::string name = scheme.substr(0, scheme.size() - 1);
  if (name == "bdf" && order <= kHighestBdf) return {Kind::backward, order};
  if (order < 2 || order > kHighestAdams) return {Kind::none, 0};
  if (name == "adams-bashforth") return {Kind::bashforth, order};
  if (name == "adams-moulton") return {Kind::moulton, order};
  return {Kind::none, 0};
}

const std::string history =
    " The history is cleared when the state is changed from outside, or the step size or the force law changes (a "
    "thruster switches).";
const std::string attitude =
    " A rotating body's quaternion is integrated as four numbers, q' = 1/2 q (0, w), beside Euler's equations in "
    "body axes, and normalised after each step; the history of rates is kept. On loops and ropes each step is followed by the "
    "projection, and the history is of projected states and their increments: of its claims the order remains.";

std::string starter(const std::string& name, int stages, int order) {
  return " The first steps are " + name + " of " + std::to_string(stages) + " stages, of order " +
         std::to_string(order) + ".";
}

int gauss_stages(int order) { return order / 2 + 1; }    // of order 2 s > order
int radau_stages(int order) { return (order + 3) / 2; }  // of order 2 s - 1 > order

}  // namespace

std::vector<MethodInfo> multistep_methods() {
  std::vector<MethodInfo> all;
  for (int order = 2; order <= kHighestAdams; ++order) {
    const int s = gauss_stages(order);
    all.push_back(
        fixed_step("adams-bashforth" + std::to_string(order), claims_in_any_coordinates(order),
                   "Adams-Bashforth of order " + std::to_string(order) + ": the polynomial through the last " +
                       std::to_string(order) +
                       " rates, integrated over the step. One evaluation per step; its stability region shrinks with "
                       "the order." +
                       starter("Gauss's method", s, 2 * s) + history + attitude,
                   "Bashforth, Adams (1883); Hairer, Norsett, Wanner, Solving ODEs I (2nd ed.), eq. III.1.5"));
  }
  for (int order = 2; order <= kHighestAdams; ++order) {
    const int s = gauss_stages(order);
    all.push_back(fixed_step("adams-moulton" + std::to_string(order), claims_in_any_coordinates(order),
                             "Adams-Moulton of order " + std::to_string(order) +
                                 ": the polynomial through the new rate and the last " + std::to_string(order - 1) +
                                 ", integrated over the step; the corrector is solved to the round-off of the scalar." +
                                 starter("Gauss's method", s, 2 * s) + history + attitude,
                             "Moulton (1926); Hairer, Norsett, Wanner, Solving ODEs I (2nd ed.), eq. III.1.8'"));
  }
  for (int order = 1; order <= kHighestBdf; ++order) {
    const int s = radau_stages(order);
    all.push_back(fixed_step(
        "bdf" + std::to_string(order), claims_in_any_coordinates(order),
        "Backward differentiation of order " + std::to_string(order) + ": the polynomial through the last " +
            std::to_string(order) +
            " states and the new one has the new one's rate; solved to the round-off of the scalar. " +
            (order <= 2 ? "L-stable." : "Stable in a wedge about the negative axis, damping at infinity.") +
            (order > 1 ? starter("Radau IIA", s, 2 * s - 1) : "") + history + attitude,
        "Curtiss, Hirschfelder, Proc. Nat. Acad. Sci. 38 (1952) 235; Hairer, Norsett, Wanner, Solving ODEs I (2nd "
        "ed.), eq. III.1.22'"));
  }
  return all;
}

template <class S> StepperResult<S> make_multistep(const StepperRequest<S>& request) {
  const auto [kind, order] = chosen(request.scheme);
  if (kind == Kind::none) return StepperPointer<S>{};
  System<S>& system = request.system;
  const bool compensated = request.flag("compensated"), backward = kind == Kind::backward;
  const CollocationTableau first =
      backward ? radau_right_collocation(radau_stages(order)) : gauss_collocation(gauss_stages(order));
  auto starter = std::make_unique<ImplicitRungeKutta<S>>(system, first, ImplicitOptions{compensated, true, false});
  const MultistepTable table = backward                  ? bdf(order)
                               : kind == Kind::bashforth ? adams_bashforth(order)
                                                         : adams_moulton(order);
  return StepperPointer<S>(std::make_unique<Multistep<S>>(system, table, std::move(starter), compensated));
}

template StepperResult<float> make_multistep(const StepperRequest<float>&);
template StepperResult<double> make_multistep(const StepperRequest<double>&);
template StepperResult<long double> make_multistep(const StepperRequest<long double>&);
template StepperResult<Quad> make_multistep(const StepperRequest<Quad>&);

}  // namespace atwood
