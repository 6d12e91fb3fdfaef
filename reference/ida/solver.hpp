// An IDA integrator as a Stepper. Its users need no SUNDIALS header.
#pragma once

#include "stepping/stepping.hpp"

namespace atwood::ida {

struct Options {
  double rtol = 1e-10, atol = 1e-12;
  int max_order = 5;
  std::int64_t max_steps = 2000000;
};

std::unique_ptr<stepping::Stepper<double>> make_solver(const Options& options,
                                                       const stepping::Equations<double>& equations,
                                                       const std::vector<double>& y);

}  // namespace atwood::ida
