// Adams-Bashforth-Moulton, predicted and corrected: each step count, and the variable-coefficient form.
#include <boost/numeric/odeint/stepper/adams_bashforth_moulton.hpp>
#include <boost/numeric/odeint/stepper/adaptive_adams_bashforth_moulton.hpp>

#include <utility>

#include "odeint/catalogue.hpp"

namespace atwood::odeint {

namespace {

template <std::size_t steps>
struct Moulton {
  template <class S> using Of = boost::numeric::odeint::adams_bashforth_moulton<steps, std::vector<S>, S>;
};
template <std::size_t steps>
struct Adaptive {
  template <class S> using Of = boost::numeric::odeint::adaptive_adams_bashforth_moulton<steps, std::vector<S>, S>;
};

template <std::size_t steps>
void add(std::vector<Entry>& all) {
  const std::string n = std::to_string(steps);
  all.push_back(plain<Moulton<steps>::template Of>("adams_bashforth_moulton" + n, "adams_bashforth_moulton<" + n + ", state>",
                                                    "Adams-Bashforth of " + n + " steps corrected once by Adams-Moulton, odeint's default starter."));
}

}  // namespace

void add_adams_moulton(std::vector<Entry>& all) {
  [&]<std::size_t... k>(std::index_sequence<k...>) { (add<k + 1>(all), ...); }(std::make_index_sequence<8>());
}

}  // namespace atwood::odeint
