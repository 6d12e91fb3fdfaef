// Methods for rotating bodies: their ids, documentation and steppers.
#include "integrators/partitioned.hpp"
#include "integrators/rotation_lie.hpp"

namespace atwood {
namespace {

const std::string exponentials =
    " The attitude moves by exponentials of rotation vectors in body axes, so that the quaternion keeps its length "
    "to round-off; positions, velocities and body rates (Euler's equations) by classical RK4 beside it.";
const std::string splitting =
    " The drift of a rotating body: rotations about its principal axes by L_i / I_i, which keep its angular momentum "
    "in the world to round-off; torques enter by kicks.";
const std::string between_kicks = " Between two half kicks by torques and forces (leapfrog-kdk).";
const std::string splitting_source =
    "McLachlan, Physica D 66 (1993) 12; Reich, Physica D 76 (1994) 375; Dullweber, Leimkuhler, McLachlan, J. Chem. "
    "Phys. 107 (1997) 5840";
const std::string exact_source =
    "Jacobi (1849); van Zon, Schofield, J. Comput. Phys. 225 (2007) 145; Celledoni, Fasso, Safstrom, Zanna, SIAM J. "
    "Sci. Comput. 30 (2008) 2084";
const std::string exact =
    " A free body turns by the exact flow: Jacobi's elliptic functions (arithmetic-geometric mean) for its momentum, "
    "Carlson's R_J for the third angle. A body without torque is exact to round-off at any step. Compensation does "
    "not act on attitude and body rate within a drift.";

struct Split {
  const char* scheme;
  const char* composition;
  FreeTop top;
};
const Split splits[] = {{"free-top2", "leapfrog-kdk", FreeTop::splitting},
                        {"free-top4", "blanes-moan4-kicks-first", FreeTop::splitting},
                        {"free-top6", "blanes-moan6", FreeTop::splitting},
                        {"moser-veselov", "leapfrog-kdk", FreeTop::moser_veselov},
                        {"implicit-midpoint-so3", "leapfrog-kdk", FreeTop::midpoint},
                        {"jacobi2", "leapfrog-kdk", FreeTop::exact},
                        {"jacobi4", "blanes-moan4-kicks-first", FreeTop::exact}};

}  // namespace

std::vector<MethodInfo> rotation_methods() {
  return {fixed_step(
              "rkmk4", claims_in_any_coordinates(4),
              "Runge-Kutta-Munthe-Kaas: RK4 for the rotation vector of the step, its rate pulled back by the inverse "
              "right Jacobian of the exponential." +
                  exponentials,
              "Munthe-Kaas, Appl. Numer. Math. 29 (1999) 115; Iserles, Munthe-Kaas, Norsett, Zanna, Acta Numerica 9 "
              "(2000) 215"),
          fixed_step(
              "lie4", claims_in_any_coordinates(4),
              "Commutator-free Lie group method of order 4: four stages, two exponentials in the last." + exponentials,
              "Celledoni, Marthinsen, Owren, Future Gener. Comput. Syst. 19 (2003) 341"),
          fixed_step("free-top2", claims_everywhere(2),
                     "The symmetric splitting of the free top." + between_kicks + splitting, splitting_source),
          fixed_step("free-top4", claims_everywhere(4),
                     "Blanes and Moan's S6, kicks first, of the split free top and its adjoint." + splitting,
                     splitting_source + "; Blanes, Moan, J. Comput. Appl. Math. 142 (2002) 313"),
          fixed_step("free-top6", claims_everywhere(6),
                     "Blanes and Moan's S10 of the split free top and its adjoint." + splitting,
                     splitting_source + "; Blanes, Moan, J. Comput. Appl. Math. 142 (2002) 313"),
          fixed_step("moser-veselov", claims_everywhere(2),
                     "The discrete Lagrangian top, h L^ = F J - J F^T for the step's rotation F, by Newton's method: "
                     "keeps angular momentum in the world to round-off." +
                         between_kicks,
                     "Moser, Veselov, Commun. Math. Phys. 139 (1991) 217; McLachlan, Zanna, Found. Comput. Math. 5 "
                     "(2005) 87; Lee, Leok, McClamroch, Comput. Methods Appl. Mech. Eng. 196 (2007) 2907"),
          fixed_step("implicit-midpoint-so3", claims_everywhere(2),
                     "The implicit midpoint rule for body momentum, attitude by Cayley's map of the same rate: keeps a "
                     "free body's energy and its angular momentum in the world to round-off." +
                         between_kicks,
                     "Austin, Krishnaprasad, Wang, J. Comput. Phys. 107 (1993) 105"),
          fixed_step("jacobi2", claims_everywhere(2), "Kick, rotate and drift, kick." + exact, exact_source),
          fixed_step("jacobi4", claims_everywhere(4), "Blanes and Moan's S6 of kicks and drifts, kicks first." + exact,
                     exact_source + "; Blanes, Moan, J. Comput. Appl. Math. 142 (2002) 313")};
}

template <class S> StepperResult<S> make_rotation(const StepperRequest<S>& request) {
  for (const auto& [scheme, composition, top] : splits)
    if (request.scheme == scheme) return make_kick_drift(request, composition, top);
  if (request.scheme != "rkmk4" && request.scheme != "lie4") return StepperPointer<S>{};
  if (without_bodies(request)) return cannot_step_bare(request.scheme, "moves bodies");
  const LieMethod method = request.scheme == "rkmk4" ? LieMethod::munthe_kaas : LieMethod::commutator_free;
  return StepperPointer<S>(std::make_unique<LieRungeKutta<S>>(*request.model, method, request.flag("compensated")));
}

template StepperResult<float> make_rotation(const StepperRequest<float>&);
template StepperResult<double> make_rotation(const StepperRequest<double>&);
template StepperResult<long double> make_rotation(const StepperRequest<long double>&);
template StepperResult<Quad> make_rotation(const StepperRequest<Quad>&);

}  // namespace atwood
