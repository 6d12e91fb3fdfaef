#include "cvode/mechanism.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/rates.hpp"
#include "mechanism/reduced.hpp"
#include "mechanism/start.hpp"
#include "protocol/refusal.hpp"
#include "scene/mechanism.hpp"

namespace atwood::cvode {

namespace {

using dynamics::operator+;

constexpr double kSingular = 1e-10;  // squared sine between a chosen constraint and the others
constexpr double kRopeEnd = 1e-4;    // of a rope's free length at the start: nearer, BDF's iteration fails
constexpr double kMaxTurn = 1;       // rad between two places at which branches of angles are remembered

std::string uncovered(const Scene& scene, Coverage coverage) {
  for (const std::string& why : {mechanism::unsupported(scene), dynamics::unsupported(scene)})
    if (!why.empty()) return why;
  const bool trees = coverage == Coverage::trees;
  if (trees && !scene.ropes.empty())
    return "ropes are constraints on the joints' coordinates; CVODE integrates trees of joints";
  for (const Joint& joint : scene.joints) {
    if (trees && joint.closes_loop) return "joint `" + joint.name + "` closes a loop; CVODE integrates trees of joints";
    if (joint.limits) return "joint `" + joint.name + "` has stops, whose impacts CVODE's adapter does not locate";
  }
  return "";
}

struct Integration {
  mechanism::Reduced<double> motion;
  mechanism::Reduced<Wide> wide;  // chooses the constraints
  bool constrained;
  std::vector<double> free_at_start;  // of each rope
  Solver solver;
  std::vector<double> y;

  Integration(const Scene& scene, double t_end_s, const Options& options, const Sample& start)
      : motion(scene, t_end_s, start), wide(scene, t_end_s, start),
        constrained(!motion.model().closing.empty() || !scene.ropes.empty()),
        solver(options, tolerances(motion, options),
               [this, repeats = options.rate_repeats](double t, const double* from, double* dydt) {
                 for (int k = 0; k < repeats; ++k) motion.rate(t, from, dydt);
               }),
        y(motion.initial(start)) {
    for (std::size_t k = 0; k < scene.ropes.size(); ++k) {
      const auto margins = rope_margins(motion.model(), static_cast<int>(k), motion.motions(y.data()), memory());
      free_at_start.push_back(std::max(margins.free_m[0], margins.free_m[1]));
    }
  }

  const mechanism::Memory& memory() const { return motion.choice.memory; }

  // In the units of options.scales, by default SI.
  static std::vector<double> tolerances(const mechanism::Reduced<double>& motion, const Options& options) {
    std::vector<double> made;
    for (const int group : motion.groups()) {
      const bool length = group == 0, speed = group == 3, turning = group == 4;
      made.push_back(options.atol * (length    ? options.scales.position_m
                                     : speed   ? options.scales.velocity_m_per_s
                                     : turning ? options.scales.rate_rad_per_s
                                               : 1));
    }
    return made;
  }

  void choose(double t) {
    if (!constrained) return;
    const std::vector<Wide> state(y.begin(), y.end());
    wide.choose(t, state.data());
    motion.choice.chosen = wide.choice.chosen;
    motion.remember_branches(y.data());
  }

  // What ends a run where it falls through zero: of each rope tension, the free ends' distance from their end, the
  // covered angle; the independence of the constraints.
  std::vector<double> margins(double t, const double* at) {
    std::vector<double> made;
    const std::vector<mechanism::Motion<double>> now = motion.motions(at);
    const std::size_t ropes = free_at_start.size();
    const Sample sample = ropes > 0 ? motion.sample(t, at) : Sample{};
    for (std::size_t k = 0; k < ropes; ++k) {
      const auto rope = rope_margins(motion.model(), static_cast<int>(k), now, memory());
      made.push_back(static_cast<double>(sample.ropes[k].tension_N));
      made.push_back(std::min(rope.free_m[0], rope.free_m[1]) - kRopeEnd * free_at_start[k]);
      made.push_back(std::min(rope.covered_rad[0], rope.covered_rad[1]) + 1e-12);
    }
    made.push_back(independence(t, at) - kSingular);
    return made;
  }
  std::string name_of(std::size_t margin) const {
    const std::size_t rope = margin / 3;
    if (rope >= free_at_start.size()) return "the mechanism is not certified past a singular configuration";
    const char* what[] = {" is slack", ": an end reaches its pulley", " leaves its pulley"};
    return "rope `" + motion.model().scene->ropes[rope].name + "`" + what[margin % 3];
  }

  // The least squared sine between a chosen constraint and the space of those before it (modified Gram-Schmidt).
  double independence(double t, const double* at) {
    std::vector<double> residual, rate_residual;
    std::vector<std::vector<double>> G;
    motion.constrained(t, at, residual, rate_residual, G);
    double least = 1;
    const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
      double sum = 0;
      for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
      return sum;
    };
    for (std::size_t i = 0; i < G.size(); ++i) {
      const double whole = product(G[i], G[i]);
      for (std::size_t j = 0; j < i; ++j) {
        const double along = product(G[i], G[j]);
        for (std::size_t k = 0; k < G[i].size(); ++k) G[i][k] -= along * G[j][k];
      }
      const double left = product(G[i], G[i]);
      least = std::min(least, whole > 0 ? left / whole : 0.0);
      for (double& x : G[i]) x /= std::sqrt(left);
    }
    return least;
  }

  // The time in which no body and no rope's end turns by more than kMaxTurn at its present rate.
  double branch_span(double t_end_s) const {
    double fastest = 0;
    const auto now = motion.motions(y.data());
    for (const auto& body : now) fastest = std::max(fastest, 2 * std::sqrt(mechanism::dot(body.w, body.w)));
    for (std::size_t k = 0; k < free_at_start.size(); ++k) {
      const Rope& rope = motion.model().scene->ropes[k];
      const auto margins = rope_margins(motion.model(), static_cast<int>(k), now, memory());
      for (int end = 0; end < 2; ++end) {
        const auto& body = now[rope.bodies[end]];
        const auto v = body.v + mechanism::cross(body.w, mechanism::rotate(
                                                             body.q, dynamics::widen<double>(rope.points_body_m[end])));
        fastest = std::max(fastest, std::sqrt(mechanism::dot(v, v)) / margins.free_m[end]);
      }
    }
    return fastest > 0 ? std::max(kMaxTurn / fastest, 1e-7 * t_end_s) : t_end_s;
  }
};

}  // namespace

Outcome run_mechanism(const Scene& scene, double t_end_s, std::int64_t samples, const Options& options,
                      const Observer& observer, std::chrono::nanoseconds* busy, Coverage coverage, double* end_s) {
  if (const std::string why = uncovered(scene, coverage); !why.empty()) return refused("CVODE: " + why);
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
    if (run.motion.size() == 0) return;  // nothing moves but by drives
    const double stop = interval < switches.size() ? switches[interval] : t_end_s;
    run.motion.choice.interval = static_cast<int>(interval);
    run.motion.choice.interval_s = t + (stop - t) / 2;
    run.choose(t);
    if (!run.constrained) return run.solver.start(t, run.y, stop, 0, {});
    const int roots = static_cast<int>(run.margins(t, run.y.data()).size());
    run.solver.start(t, run.y, stop, roots, [&run](double at_s, const double* y, double* g) {
      const std::vector<double> margins = run.margins(at_s, y);
      std::copy(margins.begin(), margins.end(), g);
    });
  };
  const auto end_by_name = [&] {
    const std::vector<double> margins = run.margins(t, run.y.data());
    const auto least = std::min_element(margins.begin(), margins.end());
    outcome.status = Status::unsupported;
    outcome.reason = "CVODE: " + run.name_of(static_cast<std::size_t>(least - margins.begin())) +
                     " at t = " + format_double(t) + " s";
    if (end_s != nullptr) *end_s = t;
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
  if (run.constrained) {
    const std::vector<double> margins = run.margins(t, run.y.data());
    if (*std::min_element(margins.begin(), margins.end()) < 0) end_by_name();
  }
  for (std::int64_t k = 1; k <= samples && outcome.status == Status::ok; ++k) {
    while (!failed && t < sample_s(k)) {
      const double stop = interval < switches.size() ? switches[interval] : t_end_s;
      double target = std::min(stop, sample_s(k));
      if (run.constrained) target = std::min(target, t + run.branch_span(t_end_s));
      const Stop reached = run.solver.advance(target, t, run.y);
      failed = reached == Stop::failed;
      if (reached == Stop::root) {
        end_by_name();
        break;
      }
      t = target;
      if (run.constrained) run.motion.remember_branches(run.y.data());
      if (!failed && t >= stop && t < t_end_s) {
        ++interval;
        restart();
      }
    }
    if ((failed && run.motion.size() > 0) || outcome.status != Status::ok) break;
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
