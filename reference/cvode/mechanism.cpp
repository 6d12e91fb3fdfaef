#include "cvode/mechanism.hpp"

#include "dynamics/rates.hpp"
#include "mechanism/reduced.hpp"
#include "mechanism/start.hpp"
#include "protocol/refusal.hpp"
#include "scene/mechanism.hpp"

namespace atwood::cvode {

namespace {

std::string uncovered(const Scene& scene) {
  for (const std::string& why : {mechanism::unsupported(scene), dynamics::unsupported(scene)})
    if (!why.empty()) return why;
  if (!scene.ropes.empty()) return "ropes are constraints on the joints' coordinates; CVODE integrates trees of joints";
  for (const Joint& joint : scene.joints) {
    if (joint.closes_loop) return "joint `" + joint.name + "` closes a loop; CVODE integrates trees of joints";
    if (joint.limits) return "the stops of joint `" + joint.name + "`: impacts of joints are not located";
  }
  return "";
}

struct Integration {
  mechanism::Reduced<double> motion;
  Solver solver;
  std::vector<double> y;

  Integration(const Scene& scene, double t_end_s, const Options& options, const Sample& start)
      : motion(scene, t_end_s, start),
        solver(options, std::vector<double>(static_cast<std::size_t>(motion.size()), options.atol),
               [this, repeats = options.rate_repeats](double t, const double* from, double* dydt) {
                 for (int k = 0; k < repeats; ++k) motion.rate(t, from, dydt);
               }),
        y(motion.initial(start)) {}
};

}  // namespace

Outcome run_mechanism(const Scene& scene, double t_end_s, std::int64_t samples, const Options& options,
                      const Observer& observer, std::chrono::nanoseconds* busy) {
  if (const std::string why = uncovered(scene); !why.empty()) return refused("CVODE: " + why);
  if (!(t_end_s > 0) || samples < 1) return refused("CVODE: nothing to run");
  Sample start;
  try {
    start = mechanism::start_sample(scene);
  } catch (const MechanismError& error) {
    return refused("CVODE: " + std::string(error.what()));
  }
  Integration run(scene, t_end_s, options, start);
  const std::vector<double>& switches = run.motion.equations().switch_times();
  Outcome outcome;
  const auto from = std::chrono::steady_clock::now();
  double t = 0;
  std::size_t interval = 0;
  const auto sample_s = [&](std::int64_t k) {
    return k == samples ? t_end_s : static_cast<double>(Wide(t_end_s) * k / samples);
  };
  const auto restart = [&] {
    const double stop = interval < switches.size() ? switches[interval] : t_end_s;
    run.motion.choice.interval = static_cast<int>(interval);
    run.motion.choice.interval_s = t + (stop - t) / 2;
    run.solver.start(t, run.y, stop, 0, {});
  };
  const auto take = [&](std::int64_t k) {
    if (!observer.sample) return;
    Sample made = run.motion.sample(sample_s(k), run.y.data());
    made.t_s = Wide(t_end_s) * k / samples;
    observer.sample(made);
  };
  restart();
  take(0);
  bool failed = run.motion.size() == 0;
  for (std::int64_t k = 1; k <= samples; ++k) {
    while (!failed && t < sample_s(k)) {
      const double stop = interval < switches.size() ? switches[interval] : t_end_s;
      const double target = std::min(stop, sample_s(k));
      failed = run.solver.advance(target, t, run.y) == Stop::failed;
      t = target;
      if (!failed && t >= stop && t < t_end_s) {
        ++interval;
        restart();
      }
    }
    if (failed && run.motion.size() > 0) break;
    take(k);
  }
  if (busy != nullptr)
    *busy = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - from);
  outcome.steps_taken = run.solver.steps();
  outcome.rate_evaluations = run.solver.rate_evaluations();
  if (!run.solver.failure().empty()) {
    outcome.status = run.solver.not_finite() ? Status::not_finite : Status::diverged;
    outcome.reason = run.solver.failure();
  }
  return outcome;
}

}  // namespace atwood::cvode
