#include "contact/penalty.hpp"

#include <cmath>
#include <optional>

#include "contact/options.hpp"
#include "contact/penalty_force.hpp"
#include "math/bracketed_root.hpp"
#include "protocol/refusal.hpp"
#include "scene/contact_laws.hpp"
#include "smooth/run.hpp"

namespace atwood {

namespace {

// Is x'' = -w^2 x - 2 z w x' stable in equal steps of h_s: bounded after 400 of them? Works for multistep methods, too,
// which have no amplification factor of one step. A motion damped to zero, where an implicit solve ends in round-off,
// is stable.
bool stable(const MethodId& scheme, double w, double z, double h_s) {
  Scene scene;
  scene.materials.push_back({"plain", 0, 0, 0});
  Body bob;
  bob.name = "bob";
  bob.mass_kg = 1;
  bob.position_m = {1, 0, 0};
  bob.velocity_m_per_s = {0, w, 0};  // two oscillations at once, a quarter period apart
  scene.bodies.push_back(bob);
  scene.forces.push_back(Spring{{0}, {0, 0, 0}, w * w, 2 * z * w, 0, {}});
  constexpr std::int64_t steps = 400;
  double size = 0;
  int seen = 0;
  Observer observer;
  observer.sample = [&](const Sample& sample) {
    const BodySample& at = sample.bodies[0];
    ++seen;
    for (int k = 0; k < 2; ++k)
      size = std::fmax(size, std::fmax(std::fabs(static_cast<double>(at.p_m[k])),
                                       std::fabs(static_cast<double>(at.v_m_per_s[k])) / w));
  };
  const Outcome outcome = run_smooth<double>(scheme, scene, {h_s * steps, steps, steps}, observer, 0);
  const bool through = outcome.status == Status::ok || seen > 20;
  return outcome.status == Status::unsupported || (through && size < 100);
}

// The longest stable step, to 0.1 %; infinite for methods that are stable at any, 0 where none above 2^-60 / w is.
double longest_step(const MethodId& scheme, double w, double z) {
  double low = 0, high = 1 / w;
  while (stable(scheme, w, z, high)) {
    low = high;
    high *= 2;
    if (high * w > 1e4) return std::numeric_limits<double>::infinity();
  }
  const auto root = bisect([&](double h_s) { return stable(scheme, w, z, h_s); }, low, high, 1e-3, 60);
  return root.converged ? root.low : 0;
}

std::optional<Fault> step_fault(const MethodId& id, double w, double z, double h_s) {
  MethodId scheme = integrator_part(id);
  scheme.response.clear();
  scheme.scalar.clear();
  if (stable(scheme, w, z, h_s)) return {};
  const double longest = longest_step(scheme, w, z);
  const std::string rate = " (" + format_double(std::round(w)) + " rad/s)";
  if (longest == 0) return Fault{"no step of atwood/" + id.scheme + " is stable on the stiffest contact" + rate};
  return Fault{"steps of " + format_double(h_s) + " s are beyond the stability limit of atwood/" + id.scheme +
               " on the stiffest contact, " + format_double(std::round(longest * 1e7) / 1e7) + " s" + rate};
}

// Compliant impacts last: several at once act together, each by its own overlap, which is neither convention.
std::optional<Fault> simultaneity_fault(const Scene& scene) {
  if (scene.simultaneous_impacts == SimultaneousImpacts::unspecified) return {};
  for (const PairLaw& law : laws_in_play(scene))
    if (law.contact_law == ContactLaw::rigid)
      return Fault{
          "the scene prescribes simultaneous_impacts for rigid pairs; impacts of +penalty have a "
          "duration, so neither convention applies"};
  return {};
}

template <class S>
Outcome run_in(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const Result<Settings> settings = response_settings(id);
  if (!settings) return refused(settings.fault());
  PenaltyOptions options;
  options.overlap = std::get<double>(settings->at("overlap"));
  options.impact_speed_m_per_s = std::get<double>(settings->at("impact_speed_m_per_s"));
  options.damping_ratio = std::get<double>(settings->at("damping_ratio"));
  options.tangential_ratio = std::get<double>(settings->at("tangential_ratio"));
  if (const auto fault = simultaneity_fault(scene)) return refused(*fault);
  auto force = std::make_unique<PenaltyForce<S>>(scene, options);
  if (!force->refusal().empty()) return refused(force->refusal());
  const auto stiffest = force->stiffest();
  if (!(stiffest.angular_frequency_rad_per_s > 0))
    return refused(
        "+penalty takes its stiffness from the largest speed, here 0: set +penalty{impact_speed_m_per_s=...}");
  const SolverTallies& narrow_phase = force->solvers();  // the model owns the force from here on
  Simulation<S> simulation = prepare<S>(integrator_part(id), scene, std::move(force), "contact forces");
  if (simulation.outcome.status == Status::ok && !id.rtol && plan.steps > 0) {
    const double h_s = plan.t_end_s / static_cast<double>(plan.steps);
    if (const auto fault = step_fault(id, stiffest.angular_frequency_rad_per_s, stiffest.damping_ratio, h_s))
      return refused(*fault);
  }
  const bool prepared = simulation.outcome.status == Status::ok;
  Outcome outcome = run_prepared(simulation, integrator_part(id), plan, observer, repeats);
  if (prepared)
    for (const auto& [name, tally] : named_tallies(narrow_phase)) outcome.solvers[name].add(tally);
  return outcome;
}

}  // namespace

Outcome run_with_penalty(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                         int repeats) {
  if (id.scalar == "float") return run_in<float>(id, scene, plan, observer, repeats);
  if (id.scalar.empty() || id.scalar == "double") return run_in<double>(id, scene, plan, observer, repeats);
  if (id.scalar == "long-double") return run_in<long double>(id, scene, plan, observer, repeats);
  return refused("atwood's contacts run in float, double and long-double, not in " + id.scalar);
}

}  // namespace atwood
