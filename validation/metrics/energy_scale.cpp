// The scale of energy errors: one per scene, for all methods and steps. Relative to its own largest energy a diverging
// run would never have an error above 1, and the worse of two runs could have the smaller drift.
#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "dynamics/arithmetic.hpp"
#include "dynamics/contacts.hpp"
#include "dynamics/invariants.hpp"
#include "dynamics/rates.hpp"
#include "scene/files.hpp"
#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood::metrics {
namespace {

constexpr int kReferenceSamples = 64;
constexpr std::int64_t kInstants = 1024;  // of the reference run, at which its energy is computed
constexpr std::int64_t kMinSteps = 1024, kMaxSteps = 65536;
constexpr double kMaxWork = 2e6;  // steps x bodies x bodies of the finest reference run
constexpr double kConverged = 1e-3;
constexpr double kSamplesSuffice = 1.01;  // ten times what the reference run is converged to
constexpr double kResolved = 0x1p-50;     // below this share of the energy's terms it is their round-off
constexpr std::size_t kManySamples = 32;

// The largest kinetic energy + |V - V0| over states of one motion.
struct EnergyPeak {
  Wide scale_J = 0, start_potential_J = 0;
  Wide terms_J = 0;  // the largest of kinetic + |V|, whose round-off the energy has
  bool started = false;
  void keep(const dynamics::Energy& e) {
    if (!started) start_potential_J = e.potential_J;
    started = true;
    scale_J = std::max(scale_J, e.kinetic_J + dynamics::magnitude(Wide(e.potential_J - start_potential_J)));
    terms_J = std::max(terms_J, e.kinetic_J + dynamics::magnitude(e.potential_J));
  }
};

EnergyPeak largest_of(const Scene& scene, const SampleSeries& samples) {
  EnergyPeak largest;
  for (const SampleView s : samples) largest.keep(dynamics::energy(scene, s));
  return largest;
}

struct ReferenceRun {
  SampleSeries samples;
  EnergyPeak largest;
};

// Classical RK4 over the reference's own rates, with `steps` steps from the start to t_end. The largest energy is over
// instants of which each falls elsewhere in its own interval t_end / kInstants: a motion whose period divides the
// interval cannot be at the same phase at all of them.
ReferenceRun reference_run(const Scenario& scenario, std::int64_t steps) {
  constexpr double golden = 0.6180339887498949;
  const Scene& scene = scenario.scene;
  const dynamics::Dynamics<double> f(scene, scenario.t_end_s);
  std::vector<double> y = dynamics::pack<double>(scene);
  std::array<std::vector<double>, 5> work;
  for (auto& w : work) w.assign(y.size(), 0.0);
  const double h = scenario.t_end_s / static_cast<double>(steps);
  const auto state = [&](std::int64_t n) {
    return dynamics::unpack<double>(scene, h * static_cast<double>(n), y.data());
  };
  ReferenceRun run;
  run.samples.push_back(state(0));
  run.largest.keep(dynamics::energy(scene, run.samples[0]));
  const std::int64_t interval = steps / kInstants;
  std::int64_t instants = 0, next = 1;
  for (std::int64_t n = 1; n <= steps; ++n) {
    reference_step(f, h * static_cast<double>(n - 1), h, y, work);
    const bool sampled = n % (steps / kReferenceSamples) == 0;
    if (n < next && !sampled) continue;
    const Sample now = state(n);
    run.largest.keep(dynamics::energy(scene, now));
    if (sampled) run.samples.push_back(now);
    if (n < next) continue;
    ++instants;
    const double turn = golden * static_cast<double>(instants);
    next =
        instants * interval + 1 + static_cast<std::int64_t>((turn - std::floor(turn)) * static_cast<double>(interval));
  }
  return run;
}

// Doubles the steps until no sample's energy changes by more than 1e-3 of the scale.
EnergyScale converged_scale(const Scenario& scenario) {
  const Scene& scene = scenario.scene;
  const double bodies = static_cast<double>(scene.bodies.size());
  SampleSeries coarse;
  for (std::int64_t steps = kMinSteps; steps <= kMaxSteps; steps *= 2) {
    if (static_cast<double>(steps) * bodies * bodies > kMaxWork) return {};
    ReferenceRun run = reference_run(scenario, steps);
    const SampleSeries& fine = run.samples;
    const double scale = static_cast<double>(run.largest.scale_J);
    if (!std::isfinite(scale) || !(run.largest.scale_J > kResolved * run.largest.terms_J)) return {};
    double change = coarse.empty() ? scale : 0;
    for (std::size_t k = 0; k < coarse.size(); ++k) {
      const dynamics::Energy a = dynamics::energy(scene, coarse[k]), b = dynamics::energy(scene, fine[k]);
      change =
          std::max(change, std::fabs(static_cast<double>(a.kinetic_J + a.potential_J - b.kinetic_J - b.potential_J)));
    }
    if (change <= kConverged * scale)
      return {scale, "reference run: classical RK4, " + std::to_string(steps) + " steps, energy converged to 1e-3"};
    coarse = std::move(run.samples);
  }
  return {};
}

// Cached: a study measures many cells of one scene without a truth, and this figure takes longest.
EnergyScale remembered_scale(const Scenario& scenario) {
  static std::mutex mutex;
  static std::map<std::string, EnergyScale> known;
  const std::string key = format_double(scenario.t_end_s) + " " + scene_to_json(scenario.scene);
  {
    const std::lock_guard lock(mutex);
    if (const auto found = known.find(key); found != known.end()) return found->second;
  }
  const EnergyScale scale = converged_scale(scenario);
  const std::lock_guard lock(mutex);
  return known[key] = scale;
}

// The scale by the reference run; none of mechanisms, of bodies that can touch, and of many bodies.
EnergyScale reference_scale(const Scenario& scenario) {
  const Scene& scene = scenario.scene;
  const auto bodies = static_cast<double>(scene.bodies.size());
  const bool moderate = static_cast<double>(kMinSteps) * bodies * bodies <= kMaxWork;
  if (!moderate || has_mechanism(scene) || !dynamics::unsupported(scene).empty() || dynamics::contacts_possible(scene))
    return {};
  return remembered_scale(scenario);
}

}  // namespace

EnergyScale energy_scale(const Scenario& scenario, const Truth& truth) {
  if (!scenario.scene.problem.empty()) return {};
  if (!has_truth(truth)) return reference_scale(scenario);
  const EnergyPeak largest = largest_of(scenario.scene, truth.values);
  const double scale = static_cast<double>(largest.scale_J);
  if (!std::isfinite(scale)) return {};
  // Few samples can miss the largest energy (all of them where they fall on whole periods).
  const EnergyScale between = declares_energy(scenario) ? reference_scale(scenario) : EnergyScale{};
  if (between.joules > kSamplesSuffice * scale)
    return {between.joules,
            between.source + ", above all " + std::to_string(truth.values.size()) + " samples of the truth"};
  if (!(largest.scale_J > kResolved * largest.terms_J)) return {};
  if (between.joules > 0 || truth.values.size() > kManySamples) return {scale, "the truth's samples"};
  return {scale, "the truth's " + std::to_string(truth.values.size()) + " samples; between them it may be larger"};
}

}  // namespace atwood::metrics
