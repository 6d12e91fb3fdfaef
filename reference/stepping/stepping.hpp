// A scene run by somebody else's stepper on the reference's own equations: equal steps or a tolerance, samples without
// interpolation. An adapter brings a Stepper; refusals, samples, counts and the timed pass are here.
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::stepping {

// y' = f(t, y) as a library sees it; reference/dynamics/state.hpp says how a scene is laid out in y. Outlives its
// stepper.
template <class S> struct Equations {
  int size = 0;
  int positions = 0;                // y[0, positions) are positions, y[positions, 2 positions) their velocities;
                                    // 0 when y is more than that (rotation, a bare problem)
  bool velocity_dependent = false;  // accelerations depend on velocities
  bool time_dependent = false;      // ... on time
  std::function<void(S t_s, const S* y, S* dydt)> rate;
  // df/dy (row-major, size x size) and df/dt of the same equations, by differences of order 4 in long double: about
  // 1e-13 of f.
  std::function<void(S t_s, const S* y, S* dfdy, S* dfdt)> jacobian;
};

// A library that gives up throws this: a status (diverged, not finite, unsupported) and its own words.
struct Failure : std::runtime_error {
  Failure(Status why, const std::string& words) : std::runtime_error(words), status(why) {}
  Status status;
};

// One of the two is called, according to whether the method was given a tolerance.
template <class S> struct Stepper {
  virtual ~Stepper() = default;
  virtual void step(S t_s, S h_s, std::vector<S>& y) = 0;  // from t to t + h, one step
  // From t to exactly `to_s`, by steps of the library's own choice; the number of them.
  virtual std::int64_t advance(S t_s, S to_s, std::vector<S>& y) = 0;
};

// Called at t = 0 with the initial state and the step (tolerance: the first guess of it).
template <class S>
using Maker = std::function<std::unique_ptr<Stepper<S>>(const Equations<S>& equations, const std::vector<S>& y, S h_s)>;

// What the equations of this scene depend on: to refuse it by name before anything runs.
bool accelerations_depend_on_velocity(const Scene& scene);
bool accelerations_depend_on_time(const Scene& scene);

// `engine` names the library in refusals. repeats > 0: the timed pass, whose clock runs while the library steps:
// equations and stepper are made before. `rate_repeats`: each evaluation is made that many times over and counts once,
// so that the time of a rate of another cost is measured with the same results. Never throws on a scene.
template <class S>
Outcome run(const std::string& engine, const Scene& scene, const Plan& plan, const Observer& observer, int repeats,
            bool by_tolerance, const Maker<S>& make, int rate_repeats = 1);

// The setting `rate_repeats` of a method id, taken out of it; `rate_repeats` stays as it is unless given. Answers what was
// expected where it is not a whole number from 1 to 1000, else nothing.
std::string take_rate_repeats(MethodId& id, int& rate_repeats);

Outcome refusal(const std::string& reason);

extern template Outcome run(const std::string&, const Scene&, const Plan&, const Observer&, int, bool,
                            const Maker<double>&, int);
extern template Outcome run(const std::string&, const Scene&, const Plan&, const Observer&, int, bool,
                            const Maker<long double>&, int);

}  // namespace atwood::stepping
