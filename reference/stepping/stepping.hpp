// Integration of a scene by a library's stepper on the reference's own equations: equal steps or a tolerance, samples
// without interpolation. An adapter provides a Stepper; refusals, samples, counts and the timed pass are here.
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

// y' = f(t, y) for a library; reference/dynamics/state.hpp describes the layout of y. It outlives its stepper.
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

// Thrown when a library fails: a status (diverged, not finite, unsupported) and its message.
struct Failure : std::runtime_error {
  Failure(Status why, const std::string& words) : std::runtime_error(words), status(why) {}
  Status status;
};

// step() is called for equal steps, advance() when the method has a tolerance.
template <class S> struct Stepper {
  virtual ~Stepper() = default;
  virtual void step(S t_s, S h_s, std::vector<S>& y) = 0;  // from t to t + h, one step
  // From t to exactly `to_s`, with step sizes of the library's choice; returns the number of steps.
  virtual std::int64_t advance(S t_s, S to_s, std::vector<S>& y) = 0;
};

// Called at t = 0 with the initial state and the step (with a tolerance: its first guess).
template <class S>
using Maker = std::function<std::unique_ptr<Stepper<S>>(const Equations<S>& equations, const std::vector<S>& y, S h_s)>;

// Dependencies of the equations of this scene, for refusals before the run.
bool accelerations_depend_on_velocity(const Scene& scene);
bool accelerations_depend_on_time(const Scene& scene);

// `engine` is the name in refusals. repeats > 0: the timed pass; the time is that of the steps, without the
// construction of equations and stepper. `rate_repeats`: each rate is evaluated this many times and counted once, which
// measures the time for a rate of higher cost with the same results. Never throws on a scene.
template <class S>
Outcome run(const std::string& engine, const Scene& scene, const Plan& plan, const Observer& observer, int repeats,
            bool by_tolerance, const Maker<S>& make, int rate_repeats = 1);

Setting rate_repeats_setting();
int rate_repeats(const Settings& settings);  // its value among checked settings

extern template Outcome run(const std::string&, const Scene&, const Plan&, const Observer&, int, bool,
                            const Maker<double>&, int);
extern template Outcome run(const std::string&, const Scene&, const Plan&, const Observer&, int, bool,
                            const Maker<long double>&, int);

}  // namespace atwood::stepping
