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
#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood::metrics {
namespace {

constexpr int kReferenceSamples = 64;
constexpr std::int64_t kMinSteps = 1024, kMaxSteps = 65536;
constexpr double kMaxWork = 2e6;  // steps x bodies x bodies of the finest reference run
constexpr double kConverged = 1e-3;

double scale_of(const Scene& scene, const SampleSeries& samples) {
  Wide scale = 0, start_potential = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const dynamics::Energy e = dynamics::energy(scene, samples[k]);
    if (k == 0) start_potential = e.potential_J;
    scale = std::max(scale, e.kinetic_J + dynamics::magnitude(Wide(e.potential_J - start_potential)));
  }
  return static_cast<double>(scale);
}

// Classical RK4 over the reference's own rates, with `steps` steps from the start to t_end.
SampleSeries reference_run(const Scenario& scenario, std::int64_t steps) {
  const dynamics::Dynamics<double> f(scenario.scene, scenario.t_end_s);
  std::vector<double> y = dynamics::pack<double>(scenario.scene);
  std::array<std::vector<double>, 5> work;
  for (auto& w : work) w.assign(y.size(), 0.0);
  const double h = scenario.t_end_s / static_cast<double>(steps);
  SampleSeries samples;
  samples.push_back(dynamics::unpack<double>(scenario.scene, 0, y.data()));
  for (std::int64_t n = 0; n < steps; ++n) {
    reference_step(f, h * static_cast<double>(n), h, y, work);
    if ((n + 1) % (steps / kReferenceSamples) == 0)
      samples.push_back(dynamics::unpack<double>(scenario.scene, h * static_cast<double>(n + 1), y.data()));
  }
  return samples;
}

// Doubles the steps until no sample's energy changes by more than 1e-3 of the scale.
EnergyScale converged_scale(const Scenario& scenario) {
  const Scene& scene = scenario.scene;
  const double bodies = static_cast<double>(scene.bodies.size());
  SampleSeries coarse;
  for (std::int64_t steps = kMinSteps; steps <= kMaxSteps; steps *= 2) {
    if (static_cast<double>(steps) * bodies * bodies > kMaxWork) return {};
    SampleSeries fine = reference_run(scenario, steps);
    const double scale = scale_of(scene, fine);
    if (!std::isfinite(scale) || !(scale > 0)) return {};
    double change = coarse.empty() ? scale : 0;
    for (std::size_t k = 0; k < coarse.size(); ++k) {
      const dynamics::Energy a = dynamics::energy(scene, coarse[k]), b = dynamics::energy(scene, fine[k]);
      change =
          std::max(change, std::fabs(static_cast<double>(a.kinetic_J + a.potential_J - b.kinetic_J - b.potential_J)));
    }
    if (change <= kConverged * scale)
      return {scale, "reference run: classical RK4, " + std::to_string(steps) + " steps, energy converged to 1e-3"};
    coarse = std::move(fine);
  }
  return {};
}

// Cached: a study measures many cells of one scene without a truth, and this figure takes longest.
EnergyScale remembered_scale(const Scenario& scenario) {
  static std::mutex mutex;
  static std::map<std::string, EnergyScale> known;
  std::string key = scenario.id + " " + format_double(scenario.t_end_s);
  for (const Body& body : scenario.scene.bodies) {
    key += " " + format_double(body.mass_kg);
    for (const auto& v : {body.position_m, body.velocity_m_per_s, body.angular_velocity_body_rad_per_s})
      for (double x : v) key += " " + format_double(x);
  }
  {
    const std::lock_guard lock(mutex);
    if (const auto found = known.find(key); found != known.end()) return found->second;
  }
  const EnergyScale scale = converged_scale(scenario);
  const std::lock_guard lock(mutex);
  return known[key] = scale;
}

}  // namespace

EnergyScale energy_scale(const Scenario& scenario, const Truth& truth) {
  if (!scenario.scene.problem.empty()) return {};
  if (!has_truth(truth)) {
    const Scene& scene = scenario.scene;
    const auto bodies = static_cast<double>(scene.bodies.size());
    const bool moderate = static_cast<double>(kMinSteps) * bodies * bodies <= kMaxWork;
    if (!moderate || has_mechanism(scene) || !dynamics::unsupported(scene).empty() ||
        dynamics::contacts_possible(scene))
      return {};
    return remembered_scale(scenario);
  }
  const double scale = scale_of(scenario.scene, truth.values);
  if (!std::isfinite(scale) || !(scale > 0)) return {};
  return {scale, "the truth's samples"};
}

}  // namespace atwood::metrics
