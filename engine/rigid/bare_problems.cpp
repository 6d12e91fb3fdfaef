#include "rigid/bare_problems.hpp"

#include "math/scalar.hpp"

namespace atwood {
namespace {

// Lorenz, J. Atmos. Sci. 20 (1963) 130, eq. 25-27, with sigma = 10, rho = 28, beta = 8/3.
template <class S> void lorenz(void*, S, const S* y, S* dydt) {
  const S sigma = S(10), rho = S(28), beta = S(8) / S(3);
  dydt[0] = sigma * (y[1] - y[0]);
  dydt[1] = y[0] * (rho - y[2]) - y[1];
  dydt[2] = y[0] * y[1] - beta * y[2];
}

}  // namespace

template <class S> BareRate<S> bare_problem_rate(const std::string& name) {
  return name == "lorenz" ? &lorenz<S> : nullptr;
}

template BareRate<float> bare_problem_rate<float>(const std::string&);
template BareRate<double> bare_problem_rate<double>(const std::string&);
template BareRate<long double> bare_problem_rate<long double>(const std::string&);
template BareRate<Quad> bare_problem_rate<Quad>(const std::string&);

}  // namespace atwood
