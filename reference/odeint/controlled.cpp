// Forms with error control: controlled and dense-output Runge-Kutta, Bulirsch-Stoer.
#include <boost/numeric/odeint/stepper/adaptive_adams_bashforth_moulton.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer_dense_out.hpp>
#include <boost/numeric/odeint/stepper/controlled_adams_bashforth_moulton.hpp>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/dense_output_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_cash_karp54.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include "odeint/catalogue.hpp"
#include "odeint/tolerance.hpp"

namespace atwood::odeint {

namespace {

namespace lib = boost::numeric::odeint;

template <class S> using CashKarp = lib::runge_kutta_cash_karp54<std::vector<S>, S>;
template <class S> using Dopri5 = lib::runge_kutta_dopri5<std::vector<S>, S>;
template <class S> using Fehlberg78 = lib::runge_kutta_fehlberg78<std::vector<S>, S>;

template <class S, class Odeint>
std::unique_ptr<stepping::Stepper<S>> make_runge_kutta(const stepping::Equations<S>& equations, const std::vector<S>& y,
                                                       S h_s, const Choice& choice) {
  return by_trial<S>(System<S>{&equations}, lib::make_controlled(S(choice.atol), S(choice.rtol), Odeint()), y, h_s);
}
template <class S, class Odeint>
std::unique_ptr<stepping::Stepper<S>> make_dense(const stepping::Equations<S>& equations, const std::vector<S>& y,
                                                 S h_s, const Choice& choice) {
  return by_dense_output<S>(System<S>{&equations}, lib::make_dense_output(S(choice.atol), S(choice.rtol), Odeint()), y,
                            h_s);
}
template <class S>
std::unique_ptr<stepping::Stepper<S>> make_bulirsch_stoer(const stepping::Equations<S>& equations,
                                                          const std::vector<S>& y, S h_s, const Choice& choice) {
  return by_trial<S>(System<S>{&equations}, lib::bulirsch_stoer<std::vector<S>, S>(S(choice.atol), S(choice.rtol)), y,
                     h_s);
}
template <class S>
std::unique_ptr<stepping::Stepper<S>> make_bulirsch_stoer_dense(const stepping::Equations<S>& equations,
                                                                const std::vector<S>& y, S h_s, const Choice& choice) {
  return by_dense_output<S>(System<S>{&equations},
                            lib::bulirsch_stoer_dense_out<std::vector<S>, S>(S(choice.atol), S(choice.rtol)), y, h_s);
}

// Variable step and order, at most `steps`; its default step adjuster takes an absolute and a relative tolerance.
template <class S>
std::unique_ptr<stepping::Stepper<S>> make_adams(const stepping::Equations<S>& equations, const std::vector<S>& y,
                                                 S h_s, const Choice& choice) {
  using Odeint = lib::controlled_adams_bashforth_moulton<lib::adaptive_adams_bashforth_moulton<5, std::vector<S>, S>>;
  return by_trial<S>(System<S>{&equations}, Odeint(typename Odeint::step_adjuster_type(choice.atol, choice.rtol)), y,
                     h_s);
}

template <template <class> class Of> Entry controlled(const std::string& stepper, const std::string& words) {
  Entry made;
  made.name = "controlled/" + stepper;
  made.type = "make_controlled(atol, rtol, " + stepper + "<state, real>())";
  made.doc = words + " with odeint's default step control.";
  made.claim = "order() of its stepper";
  made.order = Of<double>().order();
  made.form = Entry::Form::controlled;
  made.by_tolerance = true;
  made.has_in_place = false;
  made.in_double = make_runge_kutta<double, Of<double>>;
  made.in_long_double = make_runge_kutta<long double, Of<long double>>;
  return made;
}

Entry bulirsch_stoer(bool dense) {
  Entry made;
  made.name = dense ? "bulirsch_stoer_dense_out" : "bulirsch_stoer";
  made.type = made.name + "<state, real>(atol, rtol)";
  made.doc = dense ? "Bulirsch-Stoer with dense output: samples are interpolated."
                   : "Bulirsch-Stoer: extrapolation of variable order and step.";
  made.claim = "none: its order varies";
  made.form = dense ? Entry::Form::dense : Entry::Form::controlled;
  made.by_tolerance = true;
  made.has_in_place = false;
  made.in_double = dense ? make_bulirsch_stoer_dense<double> : make_bulirsch_stoer<double>;
  made.in_long_double = dense ? make_bulirsch_stoer_dense<long double> : make_bulirsch_stoer<long double>;
  return made;
}

}  // namespace

void add_controlled(std::vector<Entry>& all) {
  all.push_back(controlled<CashKarp>("runge_kutta_cash_karp54", "Cash-Karp 5(4)"));
  all.push_back(controlled<Dopri5>("runge_kutta_dopri5", "Dormand-Prince 5(4)"));
  all.push_back(controlled<Fehlberg78>("runge_kutta_fehlberg78", "Fehlberg 7(8)"));
  Entry dense = all.back();
  dense.name = "dense_output/runge_kutta_dopri5";
  dense.type = "make_dense_output(atol, rtol, runge_kutta_dopri5<state, real>())";
  dense.doc = "Dormand-Prince 5(4) with odeint's default step control and dense output: samples are interpolated.";
  dense.order = Dopri5<double>().order();
  dense.form = Entry::Form::dense;
  dense.in_double = make_dense<double, Dopri5<double>>;
  dense.in_long_double = make_dense<long double, Dopri5<long double>>;
  all.push_back(dense);
  Entry adams = bulirsch_stoer(false);
  adams.name = "controlled/adaptive_adams_bashforth_moulton5";
  adams.type =
      "controlled_adams_bashforth_moulton<adaptive_adams_bashforth_moulton<5, state, real>>(step_adjuster(atol, rtol))";
  adams.doc =
      "Adams-Bashforth-Moulton in divided differences of at most 5 steps with odeint's default control of step and "
      "order.";
  adams.in_double = make_adams<double>;
  adams.in_long_double = make_adams<long double>;
  all.push_back(adams);
  all.push_back(bulirsch_stoer(false));
  all.push_back(bulirsch_stoer(true));
}

}  // namespace atwood::odeint
