// Checks of steps for several families: reversal, repeated steps, samples inside steps.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>

#include "scenes.hpp"

namespace atwood::testing {

// n steps forward, n back with -h; in double. The largest difference of a component from the start.
inline double back_and_forth(const std::string& scheme, const Scene& scene, double h, int steps,
                             const Settings& settings = {}) {
  RigidModel<double> model(scene);
  const auto stepper = stepper_of(scheme, model, settings);
  std::vector<double> y(model.state_size()), y_new(model.state_size());
  model.initial_state(y.data());
  const std::vector<double> start = y;
  for (int n = 0; n < 2 * steps; ++n) {
    const double t = n < steps ? n * h : (2 * steps - n) * h;
    REQUIRE(stepper->step(t, n < steps ? h : -h, y.data(), y_new.data()));
    y.swap(y_new);
  }
  double worst = 0;
  for (std::size_t i = 0; i < y.size(); ++i) worst = std::max(worst, std::fabs(y[i] - start[i]));
  return worst;
}

// The worst body's distance, angle or difference of body rate at the last sample.
inline double end_error(const Recorded& run, const Recorded& truth) {
  double worst = 0;
  for (std::size_t i = 0; i < truth.samples.back().bodies.size(); ++i) {
    const BodySample &a = run.samples.back().bodies[i], &b = truth.samples.back().bodies[i];
    worst = std::max(
        {worst, distance(a.p_m, b.p_m), attitude_distance(a.q_wxyz, b.q_wxyz), distance(a.w_rad_per_s, b.w_rad_per_s)});
  }
  return worst;
}

// Kepler, tolerance 1e-12: samples inside steps change nothing of the run, and are as accurate as `truth` tells (50 of
// them).
inline void check_samples_change_nothing(const std::string& scheme, const Recorded& truth) {
  const Recorded bare = run(scheme, kepler(0.6), {10, 100, 1}, "", 1e-12),
                 sampled = run(scheme, kepler(0.6), {10, 100, 50}, "", 1e-12);
  CHECK(end_error(bare, sampled) == 0);
  for (std::size_t k = 0; k < truth.samples.size(); ++k)
    CHECK(distance(sampled.samples[k].bodies[0].p_m, truth.samples[k].bodies[0].p_m) < 1e-10);
}

// Two steppers of one scheme on Kepler's problem: one that has stepped already, and one that has not.
struct Twins {
  explicit Twins(const std::string& scheme) : model(kepler(0.6)), other(kepler(0.6)) {
    again = stepper_of(scheme, model);
    fresh = stepper_of(scheme, other);
    model.initial_state(y.data());
  }
  void step(double h) { REQUIRE(again->step(0, h, y.data(), near.data())); }
  void check_step(double h) {
    step(h);
    REQUIRE(fresh->step(0, h, y.data(), wanted.data()));
    for (int i = 0; i < 6; ++i) CHECK(near[i] == Approx(wanted[i]).margin(1e-15));
  }

  RigidModel<double> model, other;
  std::unique_ptr<Stepper<double>> again, fresh;
  std::vector<double> y = std::vector<double>(6), near = y, wanted = y;
};

}  // namespace atwood::testing
