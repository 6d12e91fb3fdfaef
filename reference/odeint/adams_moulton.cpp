// Adams-Bashforth-Moulton, predicted and corrected: each step count, and the variable-coefficient form.
#include <boost/numeric/odeint/stepper/adams_bashforth_moulton.hpp>
#include <boost/numeric/odeint/stepper/adams_moulton.hpp>
#include <boost/numeric/odeint/stepper/adaptive_adams_bashforth_moulton.hpp>
#include <utility>

#include "odeint/catalogue.hpp"

namespace atwood::odeint {

namespace {

template <std::size_t steps> struct Moulton {
  template <class S> using Of = boost::numeric::odeint::adams_bashforth_moulton<steps, std::vector<S>, S>;
};
template <std::size_t steps> struct Adaptive {
  template <class S> using Of = boost::numeric::odeint::adaptive_adams_bashforth_moulton<steps, std::vector<S>, S>;
};

template <std::size_t steps> void add(std::vector<Entry>& all) {
  const std::string n = std::to_string(steps);
  all.push_back(plain<Moulton<steps>::template Of>(
      "adams_bashforth_moulton" + n, "adams_bashforth_moulton<" + n + ", state, real>",
      "Adams-Bashforth of " + n + " steps corrected once by Adams-Moulton, odeint's default starter."));
}

// adams_moulton cannot step by itself: it needs a prediction and past derivatives, which adams_bashforth_moulton
// supplies. The corrected steps of the latter show the corrector's order (one correction of a prediction of order p - 1
// has order p).
template <std::size_t steps> void add_corrector(std::vector<Entry>& all) {
  const std::string n = std::to_string(steps);
  Entry made = plain<Moulton<steps>::template Of>(
      "adams_moulton" + n, "adams_bashforth_moulton<" + n + ", state, real>",
      "The corrector adams_moulton of " + n + " steps, inside adams_bashforth_moulton.");
  made.order = boost::numeric::odeint::adams_moulton<steps, std::vector<double>>().order();
  made.claim = "order() of adams_moulton<" + n + ">";
  made.has_in_place = false;
  all.push_back(made);
}

template <std::size_t steps> void add_adaptive(std::vector<Entry>& all) {
  const std::string n = std::to_string(steps);
  all.push_back(plain<Adaptive<steps>::template Of>(
      "adaptive_adams_bashforth_moulton" + n, "adaptive_adams_bashforth_moulton<" + n + ", state, real>",
      "Adams-Bashforth-Moulton in divided differences of " + n + " steps, equal steps, from order 1 up."));
}

}  // namespace

void add_adams_moulton(std::vector<Entry>& all) {
  [&]<std::size_t... k>(std::index_sequence<k...>) { (add<k + 1>(all), ...); }
  (std::make_index_sequence<8>());
  [&]<std::size_t... k>(std::index_sequence<k...>) { (add_corrector<k + 1>(all), ...); }
  (std::make_index_sequence<4>());
  [&]<std::size_t... k>(std::index_sequence<k...>) { (add_adaptive<k + 2>(all), ...); }
  (std::make_index_sequence<4>());
}

}  // namespace atwood::odeint
