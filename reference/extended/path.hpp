// Integration of a scene's whole motion with one method: from sample to sample, restarted at switches, releases and
// impacts.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/rates.hpp"
#include "extended/impacts.hpp"
#include "extended/problem.hpp"
#include "protocol/ragged_array.hpp"

namespace atwood::extended {

template <class S> struct Path {
  RaggedArray<S> states;  // at t_end k / samples
  std::vector<Event> events;
  std::vector<Instant<S>> instants;  // with contacts: samples, switches, impacts and passages, in order
  std::string failure;               // empty: the whole motion was integrated
  bool valid_until_failure = false;  // the motion before the failure is valid
  S end{};                           // [s] time that was reached
  std::int64_t steps = 0, evaluations = 0;
};

// Makes the integrator from the rates, in S and in double.
template <class S>
using MakeStepper = std::function<std::unique_ptr<Stepper<S>>(Rate<S> rate, Rate<double> narrow_rate)>;

// `initial` in dynamics::layout; samples >= 1. Impacts are located to the round-off of S. What is not covered, and a
// singular motion or one that takes more than `most_evaluations` of the rates (0: any number), is reported in
// Path::failure; the samples and events before it are kept. Never throws.
template <class S>
Path<S> integrate_path(const Scene& scene, double t_end_s, std::int64_t samples, const std::vector<S>& initial,
                       const MakeStepper<S>& make, Grid grid = Grid::samples, std::int64_t most_evaluations = 0);

}  // namespace atwood::extended
