// The run of an engine that takes plan.steps equal steps: when it is observed and what is timed.
#pragma once

#include "protocol/timed_passes.hpp"
#include "scene/scene.hpp"

namespace atwood {

// A body as a scene gives it.
inline BodySample sample_of(const Body& body) {
  BodySample sample;
  for (int k = 0; k < 3; ++k) sample.p_m[k] = body.position_m[k], sample.v_m_per_s[k] = body.velocity_m_per_s[k];
  for (int k = 0; k < 4; ++k) sample.q_wxyz[k] = body.orientation_wxyz[k];
  for (int k = 0; k < 3; ++k) sample.w_rad_per_s[k] = body.angular_velocity_body_rad_per_s[k];
  return sample;
}
inline std::vector<BodySample> samples_of(const std::vector<Body>& bodies) {
  std::vector<BodySample> samples;
  for (const Body& body : bodies) samples.push_back(sample_of(body));
  return samples;
}

// `make()` builds the world of a pass, `step(world, h_s)` takes one step of it, `sample(world)` gives its bodies in the
// order of the scene. The accuracy pass (repeats = 0) samples at t = 0 and wherever the plan has a sample. A timed pass
// takes no samples, and measures only the steps.
template <class Make, class Step, class Sampler>
Outcome equal_steps(const Plan& plan, const Observer& observer, int repeats, const Make& make, const Step& step,
                    const Sampler& sample) {
  const double h_s = plan.t_end_s / static_cast<double>(plan.steps);
  const bool samples_wanted = repeats == 0 && observer.sample != nullptr;
  return timed_passes(repeats, [&](std::chrono::nanoseconds& busy) {
    auto world = make();
    const auto start = std::chrono::steady_clock::now();
    for (std::int64_t n = 0; n <= plan.steps; ++n) {
      if (samples_wanted && n % (plan.steps / plan.samples) == 0)
        observer.sample({step_begin_s<Wide>(plan, n), sample(world)});
      if (n < plan.steps) step(world, h_s);
    }
    busy = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start);
    Outcome outcome;
    outcome.steps_taken = plan.steps;
    return outcome;
  });
}

}  // namespace atwood
