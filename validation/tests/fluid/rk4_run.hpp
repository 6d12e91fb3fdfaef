// Runs of a fluid by RK4 in equal steps, with the fault asked for after every step.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "fluid/polynomial.hpp"
#include "integrators/catalogue.hpp"

namespace atwood {

// The state at t_end_s; a fault fails the test or, with `fault`, is kept there and ends the run with an empty state.
inline std::vector<double> run_rk4(fluid::Polynomial<double>& fluid, double t_end_s, int steps,
                                   std::string* fault = nullptr) {
  auto stepper = make_stepper<double>("rk4", fluid.system(), {});
  REQUIRE(stepper);
  std::vector<double> y(fluid.layout().size()), next(y.size());
  fluid.initial_state(y.data());
  for (int n = 0; n < steps; ++n) {
    REQUIRE((*stepper)->step(n * t_end_s / steps, t_end_s / steps, y.data(), next.data()));
    y.swap(next);
    const std::string found = fluid.fault(y.data());
    if (fault == nullptr) REQUIRE(found == "");
    else if (!found.empty()) {
      *fault = found;
      return {};
    }
  }
  return y;
}

}  // namespace atwood
