// Explicit Runge-Kutta methods: their ids, documentation and tableaux.
#include "integrators/families.hpp"
#include "integrators/runge_kutta.hpp"
#include "integrators/tableaux.hpp"

namespace atwood {
namespace {

struct Entry {
  const char* scheme;
  const Tableau* tableau;
  const char* doc;
  const char* source;
};

// The sentences common to all pairs are composed in about(), from the tableau.
const Entry entries[] = {
    {"explicit-euler", &explicit_euler_tableau, "Explicit Euler: p_new = p + h v, v_new = v + h a(t, p, v).",
     "Euler, Institutionum calculi integralis I (1768), section 650; Hairer, Norsett, Wanner, Solving ODEs I, eq. "
     "I.7.3"},
    {"midpoint", &midpoint_tableau, "Explicit midpoint rule.",
     "Runge, Math. Ann. 46 (1895) 167; Hairer, Norsett, Wanner I, eq. II.1.4"},
    {"heun", &heun_tableau, "Heun's method, the explicit trapezoidal rule.",
     "Heun, Z. Math. Phys. 45 (1900) 23; Hairer, Norsett, Wanner I, table II.1.1"},
    {"ralston2", &ralston2_tableau,
     "Ralston's two stages, with the least bound on the local error that two stages can have.",
     "Ralston, Math. Comp. 16 (1962) 431, eq. 3.5"},
    {"kutta3", &kutta3_tableau, "Kutta's third-order method.",
     "Kutta, Z. Math. Phys. 46 (1901) 435; Hairer, Norsett, Wanner I, table II.1.1"},
    {"rk4", &rk4_tableau, "The classical Runge-Kutta method.",
     "Kutta, Z. Math. Phys. 46 (1901) 435; Hairer, Norsett, Wanner I, table II.1.2"},
    {"rk38", &rk38_tableau, "The 3/8 rule.",
     "Kutta, Z. Math. Phys. 46 (1901) 435; Hairer, Norsett, Wanner I, table II.1.2"},
    {"bogacki-shampine3", &bogacki_shampine3_tableau, "Bogacki and Shampine's pair.",
     "Bogacki, Shampine, Appl. Math. Lett. 2 (1989) 321"},
    {"rkf45", &fehlberg45_tableau, "Fehlberg's pair.",
     "Fehlberg, NASA TR R-315 (1969), table III; Hairer, Norsett, Wanner I, table II.5.1"},
    {"cash-karp5", &cash_karp5_tableau,
     "Cash and Karp's pair of orders 5 and 4, without their solutions of lower order.",
     "Cash, Karp, ACM Trans. Math. Softw. 16 (1990) 201, section 2"},
    {"dopri5", &dormand_prince5_tableau, "Dormand and Prince's pair.",
     "Dormand, Prince, J. Comput. Appl. Math. 6 (1980) 19, table 2; Hairer, Norsett, Wanner I, table II.5.2 and eq. "
     "II.6.12"},
    {"tsit5", &tsitouras5_tableau,
     "Tsitouras's pair, which satisfies only the first column simplifying assumption. The interpolant is not the "
     "paper's, which is not smooth, but a smooth one derived here.",
     "Tsitouras, Comput. Math. Appl. 62 (2011) 770, table 1"},
    {"verner6", &verner6_tableau,
     "Verner's \"most robust\" pair of orders 6 and 5. The interpolant is not his, but derived here.",
     "Verner, Numer. Algorithms 53 (2010) 383, and the tables on his pages"},
    {"rkf78", &fehlberg78_tableau,
     "Fehlberg's pair. The estimate is 0 where"
     " the rate depends on t only.",
     "Fehlberg, NASA TR R-287 (1968), table X"},
    {"verner8", &verner8_tableau,
     "Verner's \"most robust\" pair of orders 8 and 7. The interpolant is not his, but derived here.",
     "Verner, Numer. Algorithms 53 (2010) 383, and the tables on his pages"},
    {"dop853", &dormand_prince853_tableau,
     "Dormand and Prince's method of order 8 with Hairer's estimates of orders 5 and 3, which combine to one of "
     "order 7: e = e5^2 / sqrt(e5^2 + e3^2 / 100).",
     "Hairer, Norsett, Wanner I, section II.5, eq. II.10.17 and the code DOP853"},
    {"verner9", &verner9_tableau,
     "Verner's \"most efficient\" pair of orders 9 and 8. The interpolant is not his, but derived here.",
     "Verner, Numer. Algorithms 53 (2010) 383, and the tables on his pages"}};

std::string evaluations(const Tableau& t) {
  const std::string stages = " " + std::to_string(t.stages) + (t.stages == 1 ? " stage" : " stages");
  if (!t.first_same_as_last) return stages + " and as many evaluations per step.";
  return stages + ", the last one shared with the next step: " + std::to_string(t.stages - 1) +
         " evaluations per step.";
}

std::string dense_output(const Tableau& t) {
  if (t.dense_order == 0) return "samples by a shorter step of the same method.";
  std::string own = t.dense_order == 3 ? "samples by the cubic Hermite polynomial, of order 3"
                                       : "samples by its own interpolant of order " + std::to_string(t.dense_order);
  if (t.dense_stages > 0)
    own += ", whose " + std::to_string(t.dense_stages) + " further stages are evaluated only for samples";
  return own + ".";
}

std::string about(const Entry& entry) {
  const Tableau& t = *entry.tableau;
  std::string doc = entry.doc + evaluations(t);
  if (t.embedded_order > 0)
    doc += " The solution of order " + std::to_string(t.order) + " advances the state, that of order " +
           std::to_string(t.embedded_order) +
           " estimates its error. Without a tolerance: equal steps. With one: PI step control, " + dense_output(t);
  return doc + embedded_attitude;
}

}  // namespace

std::vector<MethodInfo> explicit_runge_kutta_methods() {
  std::vector<MethodInfo> methods;
  for (const Entry& entry : entries) {
    const auto make = entry.tableau->embedded_order > 0 ? with_tolerance : fixed_step;
    methods.push_back(make(entry.scheme, claims_in_any_coordinates(entry.tableau->order), about(entry), entry.source));
  }
  return methods;
}

template <class S> StepperResult<S> make_explicit_runge_kutta(const StepperRequest<S>& request) {
  for (const Entry& entry : entries)
    if (request.scheme == entry.scheme)
      return StepperPointer<S>(
          std::make_unique<ExplicitRungeKutta<S>>(request.system, *entry.tableau, request.flag("compensated")));
  return StepperPointer<S>{};
}

template StepperResult<float> make_explicit_runge_kutta(const StepperRequest<float>&);
template StepperResult<double> make_explicit_runge_kutta(const StepperRequest<double>&);
template StepperResult<long double> make_explicit_runge_kutta(const StepperRequest<long double>&);
template StepperResult<Quad> make_explicit_runge_kutta(const StepperRequest<Quad>&);

}  // namespace atwood
