// Adams-Bashforth, each step count that odeint allows.
#include <boost/numeric/odeint/stepper/adams_bashforth.hpp>
#include <utility>

#include "odeint/catalogue.hpp"

namespace atwood::odeint {

namespace {

template <std::size_t steps> struct Bashforth {
  template <class S> using Of = boost::numeric::odeint::adams_bashforth<steps, std::vector<S>, S>;
};

template <std::size_t steps> Entry entry() {
  const std::string n = std::to_string(steps);
  Entry made =
      plain<Bashforth<steps>::template Of>("adams_bashforth" + n, "adams_bashforth<" + n + ", state, real>",
                                           "Adams-Bashforth of " + n + " steps, started by odeint's default starter.");
  return made;
}

}  // namespace

void add_adams_bashforth(std::vector<Entry>& all) {
  [&]<std::size_t... k>(std::index_sequence<k...>) { (all.push_back(entry<k + 1>()), ...); }
  (std::make_index_sequence<8>());
}

}  // namespace atwood::odeint
