// One method's walk along a scene's whole motion: from sample to sample, restarted at switches, releases and impacts.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/rates.hpp"
#include "extended/impacts.hpp"
#include "extended/problem.hpp"

namespace atwood::extended {

template <class S> struct Path {
  std::vector<std::vector<S>> states;  // at t_end k / samples
  std::vector<Event> events;
  std::vector<Instant<S>> instants;  // of scenes with contacts: samples, switches, impacts and passages, in order
  std::string failure;               // empty: it came to the end
  bool branch = false;               // the failure is that of one instant: up to it all is well
  S end{};                           // how far it came
  std::int64_t steps = 0, evaluations = 0;
};

// Makes the method under trial for one smooth stretch's equations.
template <class S>
using MakeStepper = std::function<std::unique_ptr<Stepper<S>>(Rate<S> rate, Rate<double> narrow_rate)>;

// `initial` in dynamics::layout. Impacts are located as closely as S resolves.
template <class S>
Path<S> walk(const Scene& scene, double t_end_s, std::int64_t samples, const std::vector<S>& initial,
             const MakeStepper<S>& make);

}  // namespace atwood::extended
