// One-step steppers without error control.
#include <boost/numeric/odeint/stepper/euler.hpp>
#include <boost/numeric/odeint/stepper/extrapolation_stepper.hpp>
#include <boost/numeric/odeint/stepper/modified_midpoint.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4_classic.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_cash_karp54.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_cash_karp54_classic.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include "odeint/catalogue.hpp"

namespace atwood::odeint {

namespace {

namespace lib = boost::numeric::odeint;

template <class S> using Euler = lib::euler<std::vector<S>, S>;
template <class S> using Midpoint = lib::modified_midpoint<std::vector<S>, S>;
template <class S> using Rk4 = lib::runge_kutta4<std::vector<S>, S>;
template <class S> using Rk4Classic = lib::runge_kutta4_classic<std::vector<S>, S>;
template <class S> using CashKarp = lib::runge_kutta_cash_karp54<std::vector<S>, S>;
template <class S> using CashKarpClassic = lib::runge_kutta_cash_karp54_classic<std::vector<S>, S>;
template <class S> using Dopri5 = lib::runge_kutta_dopri5<std::vector<S>, S>;
template <class S> using Fehlberg78 = lib::runge_kutta_fehlberg78<std::vector<S>, S>;
template <class S> using Extrapolation4 = lib::extrapolation_stepper<4, std::vector<S>, S>;
template <class S> using Extrapolation6 = lib::extrapolation_stepper<6, std::vector<S>, S>;
template <class S> using Extrapolation8 = lib::extrapolation_stepper<8, std::vector<S>, S>;

}  // namespace

void add_runge_kutta(std::vector<Entry>& all) {
  all.push_back(plain<Euler>("euler", "euler<state, real>", "Explicit Euler."));
  all.push_back(plain<Midpoint>("modified_midpoint", "modified_midpoint<state, real>",
                                "The modified midpoint rule with two substeps and Gragg's smoothing."));
  all.push_back(plain<Rk4>("runge_kutta4", "runge_kutta4<state, real>",
                           "The classical Runge-Kutta method by the generic tableau algorithm."));
  all.push_back(plain<Rk4Classic>("runge_kutta4_classic", "runge_kutta4_classic<state, real>",
                                  "The classical Runge-Kutta method, written out."));
  all.push_back(plain<CashKarp>("runge_kutta_cash_karp54", "runge_kutta_cash_karp54<state, real>",
                                "Cash-Karp 5(4) by the generic tableau algorithm, equal steps."));
  all.push_back(plain<CashKarpClassic>("runge_kutta_cash_karp54_classic",
                                       "runge_kutta_cash_karp54_classic<state, real>",
                                       "Cash-Karp 5(4), written out, equal steps."));
  all.push_back(plain<Dopri5>("runge_kutta_dopri5", "runge_kutta_dopri5<state, real>",
                              "Dormand-Prince 5(4), first same as last, equal steps."));
  all.push_back(plain<Fehlberg78>("runge_kutta_fehlberg78", "runge_kutta_fehlberg78<state, real>",
                                  "Fehlberg 7(8), equal steps."));
  all.push_back(plain<Extrapolation4>("extrapolation_stepper4", "extrapolation_stepper<4, state, real>",
                                      "Extrapolation of the modified midpoint rule to order 4."));
  all.push_back(plain<Extrapolation6>("extrapolation_stepper6", "extrapolation_stepper<6, state, real>",
                                      "Extrapolation of the modified midpoint rule to order 6."));
  all.push_back(plain<Extrapolation8>("extrapolation_stepper8", "extrapolation_stepper<8, state, real>",
                                      "Extrapolation of the modified midpoint rule to order 8."));
}

}  // namespace atwood::odeint
