// Errors of the invariants that the scenario declares, from states by the reference's formulas.
#include <algorithm>
#include <cmath>

#include "dynamics/arithmetic.hpp"
#include "dynamics/invariants.hpp"
#include "dynamics/swinging_atwood.hpp"
#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"
#include "validation/metrics/slope_fit.hpp"

namespace atwood::metrics {
namespace {

using dynamics::Wide3;
using dynamics::operator+;
using dynamics::operator-;
using dynamics::operator*;

bool declares(const Scenario& scenario, const std::string& quantity) {
  return std::any_of(scenario.invariants.begin(), scenario.invariants.end(),
                     [&](const Invariant& i) { return i.quantity == quantity; });
}

struct Change {
  double largest = 0, size = 0;
};
void keep(Change& change, const Wide3& now, const Wide3& expected) {
  change.largest = std::max(change.largest, distance(now, expected));
  change.size = std::max(change.size, norm(now));
}

// The fixed centre of an attractor or of an anchored spring, if there is one.
bool pivot(const Scene& scene, Wide3& point) {
  for (const Force& force : scene.forces) {
    if (const auto* a = std::get_if<Attractor>(&force)) {
      point = dynamics::widen<Wide>(a->center_m);
      return true;
    }
    if (const auto* s = std::get_if<Spring>(&force); s && s->bodies.size() == 1) {
      point = dynamics::widen<Wide>(s->anchor_m);
      return true;
    }
  }
  return false;
}

void append_momentum(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  const Scene& scene = scenario.scene;
  const Wide3 weight = dynamics::total_mass_kg(scene) * dynamics::widen<Wide>(scene.gravity_m_per_s2);
  const Wide3 start = dynamics::momentum(scene, run.values.front());
  Change change;
  double size = 0;
  for (const SampleView s : run.values) {
    keep(change, dynamics::momentum(scene, s), start + Wide(s.t_s - run.values.front().t_s) * weight);
    double sum = 0;
    for (std::size_t b = 0; b < s.bodies.size(); ++b)
      if (!scene.bodies[b].fixed) sum += scene.bodies[b].mass_kg * norm(s.bodies[b].v_m_per_s);
    size = std::max(size, sum);
  }
  rows.push_back(row("momentum-error", change.largest));
  if (size > 0) rows.push_back(row("momentum-error-relative", change.largest / size));
}

void append_angular_momentum(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  const Scene& scene = scenario.scene;
  Wide3 point{};
  const bool pivoted = pivot(scene, point);
  const bool origin = pivoted || dynamics::conserves(scene, "angular-momentum") ||
                      !dynamics::conserves(scene, "angular-momentum-center");
  const bool center = !pivoted && dynamics::conserves(scene, "angular-momentum-center");
  const auto about = [&](const SampleView& s) {
    return dynamics::angular_momentum(scene, s) - dynamics::cross(point, dynamics::momentum(scene, s));
  };
  Change at_point, at_center;
  for (const SampleView s : run.values) {
    if (origin) keep(at_point, about(s), about(run.values.front()));
    if (center)
      keep(at_center, dynamics::angular_momentum_about_center(scene, s),
           dynamics::angular_momentum_about_center(scene, run.values.front()));
  }
  const Change& worst = at_point.largest >= at_center.largest ? at_point : at_center;
  rows.push_back(row("angular-momentum-error", worst.largest));
  const double size = std::max(at_point.size, at_center.size);
  if (size > 0) rows.push_back(row("angular-momentum-error-relative", worst.largest / size));
}

void append_center_of_mass(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  const Scene& scene = scenario.scene;
  const SampleView& first = run.values.front();
  const Wide3 x0 = dynamics::center_of_mass(scene, first), g = dynamics::widen<Wide>(scene.gravity_m_per_s2);
  const Wide3 v0 = (1 / dynamics::total_mass_kg(scene)) * dynamics::momentum(scene, first);
  double largest = 0;
  for (const SampleView s : run.values) {
    const Wide t = s.t_s - first.t_s;
    largest = std::max(largest, distance(dynamics::center_of_mass(scene, s), x0 + t * v0 + Wide(t * t / 2) * g));
  }
  rows.push_back(row("center-of-mass-error", largest));
}

// mu of the orbit whose Laplace-Runge-Lenz vector the reference computes.
double orbit_mu(const Scene& scene, int body) {
  for (const Force& force : scene.forces)
    if (const auto* a = std::get_if<Attractor>(&force); a && std::ranges::count(a->bodies, body))
      return a->mu_m3_per_s2;
  for (const Force& force : scene.forces)
    if (const auto* g = std::get_if<MutualGravity>(&force); g && scene.bodies.size() > 1)
      return g->constant_m3_per_kg_s2 * (scene.bodies[0].mass_kg + scene.bodies[1].mass_kg);
  return 0;
}

void append_orbit_vector(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  double worst = -1;
  for (int b = 0; b < static_cast<int>(scenario.scene.bodies.size()); ++b) {
    const double mu = orbit_mu(scenario.scene, b);
    Change change;
    for (const SampleView s : run.values)
      keep(change, dynamics::laplace_runge_lenz(scenario.scene, s, b),
           dynamics::laplace_runge_lenz(scenario.scene, run.values.front(), b));
    if (mu > 0 && !scenario.scene.bodies[b].fixed) worst = std::max(worst, change.largest / mu);
  }
  if (worst >= 0) rows.push_back(row("laplace-runge-lenz-error", worst));
}

void append_magnetic_moment(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  double worst = -1;
  for (int b = 0; b < static_cast<int>(scenario.scene.bodies.size()); ++b) {
    const Wide start = dynamics::magnetic_moment(scenario.scene, run.values.front(), b);
    if (!(start > 0)) continue;
    for (const SampleView s : run.values)
      worst = std::max(
          worst, std::fabs(static_cast<double>((dynamics::magnetic_moment(scenario.scene, s, b) - start) / start)));
  }
  if (worst >= 0) rows.push_back(row("magnetic-moment-error", worst));
}

Row drift_row(const std::string& metric, const DriftFit& drift, double floor, std::size_t samples) {
  if (drift.largest <= 30 * floor)
    return row(
        metric, std::nan(""), 0,
        "inconclusive: round-off: |E - E0| stays below 30 u sqrt(steps), where one run is one draw; a drift there "
        "needs the probe `ensemble`");
  const double slope = drift.slope_per_s, bar = drift.half_width_95;
  if (samples < 5 || !std::isfinite(bar))
    return row(metric, std::nan(""), 0,
               "inconclusive: no interval follows from " + std::to_string(samples) + " samples" +
                   (samples < 5 ? "; a drift needs 5" : ""));
  std::string text = slope > bar || (drift.one_sign && slope > 0)    ? "gains energy"
                     : slope < -bar || (drift.one_sign && slope < 0) ? "loses energy"
                                                                     : "no drift outside its interval";
  if (drift.one_sign) text += " in each eighth of the run";
  if (drift.period_s > 0) text += ", period " + format_measure(drift.period_s, 0) + " s removed";
  if (!drift.stationary)
    text += (samples < 10 ? "; " + std::to_string(samples) +
                                " samples are too few to show that it is stationary about a line: the mean slope, and "
                                "its bar from the slopes of its "
                          : "; not stationary about a line: the mean slope, and its bar from the slopes of ") +
            (samples > 8 ? "eight" : std::to_string(samples - 1)) + " parts" + (samples < 10 ? "" : " of the run");
  return row(metric, slope, bar, text);
}

// Drift and oscillation of the judged instants, the largest change of all.
DriftFit drift_of(const Observed& all, const std::vector<double>& energy, std::vector<double>& t) {
  std::vector<double> judged;
  double largest = 0;
  for (std::size_t k = 0; k < energy.size(); ++k) {
    largest = std::max(largest, std::fabs(energy[k]));
    if (!all.judged[k]) continue;
    t.push_back(static_cast<double>(all.run.values[k].t_s));
    judged.push_back(energy[k]);
  }
  DriftFit drift = fit_drift(t, judged);
  drift.largest = largest;
  return drift;
}

void append_energy(const Scenario& scenario, const Truth& truth, const Recording& run, const Observed& all,
                   std::vector<Row>& rows) {
  const EnergyScale scale = energy_scale(scenario, truth);
  const std::vector<double> energy = energy_change(scenario, all.run, scale);
  if (energy.empty()) return;
  std::vector<double> t;
  const DriftFit drift = drift_of(all, energy, t);
  const double floor = energy_floor(scenario, run, scale);
  if (!(scale.joules > 0)) {
    rows.push_back(row("energy-change-max", drift.largest, 0,
                       has_truth(truth)
                           ? "in joules: the truth's samples show no energy above round-off, and no reference run is "
                             "converged"
                           : "in joules: neither a truth nor a converged reference run"));
    rows.push_back(drift_row("energy-change-drift", drift, floor, t.size()));
    rows.push_back(row("energy-change-oscillation", drift.oscillation));
    return;
  }
  rows.push_back(row("energy-scale", scale.joules, 0, scale.source));
  rows.push_back(row("energy-max", drift.largest));
  rows.push_back(drift_row("energy-drift", drift, floor, t.size()));
  rows.push_back(row("energy-oscillation", drift.oscillation));
  if (declares(scenario, "jacobi-constant")) rows.push_back(row("jacobi-constant-error", drift.largest));
}

void append_swinging_atwood(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  if (!dynamics::is_swinging_atwood_machine(scenario.scene)) return;
  const Wide start = dynamics::swinging_atwood(scenario.scene, run.values.front()).invariant;
  double largest = 0, size = 0;
  for (const SampleView s : run.values) {
    const dynamics::SwingingAtwood now = dynamics::swinging_atwood(scenario.scene, s);
    largest = std::max(largest, static_cast<double>(dynamics::magnitude(Wide(now.invariant - start))));
    size = std::max(size, static_cast<double>(now.size));
  }
  if (size > 0) rows.push_back(row("swinging-atwood-error", largest / size));
}

}  // namespace

std::vector<Wide> mechanical_energy(const Scene& scene, const Recording& run) {
  std::vector<Wide> energies;
  // The potential of a joint's spring needs its angle with all turns.
  const bool counted = scene.joint_forces.empty();
  const SampleSeries turned = counted ? SampleSeries() : with_joints(scene, run).values;
  for (const SampleView s : counted ? run.values : turned) {
    const dynamics::Energy e = dynamics::energy(scene, s);
    energies.push_back(e.kinetic_J + e.potential_J);
  }
  return energies;
}

bool declares_energy(const Scenario& scenario) {
  return declares(scenario, "energy") || declares(scenario, "jacobi-constant");
}

std::vector<double> energy_change(const Scenario& scenario, const Recording& run, const EnergyScale& scale) {
  if (!scenario.scene.problem.empty()) return {};
  if (!declares_energy(scenario)) return {};
  const std::vector<Wide> energies = mechanical_energy(scenario.scene, run);
  const Wide unit = scale.joules > 0 ? scale.joules : 1;
  std::vector<double> change;
  for (const Wide& energy : energies) change.push_back(static_cast<double>((energy - energies.front()) / unit));
  return change;
}

double relative_floor(const Scene& scene, const Recording& run) {
  const double steps =
      static_cast<double>(std::max(run.outcome.steps_taken, static_cast<std::int64_t>(run.values.size())));
  return round_off_floor(recorded_unit_round_off(scene, run), steps, 1, 1);
}

double energy_floor(const Scenario& scenario, const Recording& run, const EnergyScale& scale) {
  const double relative = relative_floor(scenario.scene, run);
  if (scale.joules > 0) return relative;
  Wide largest = 0;
  for (const SampleView s : run.values) {
    const dynamics::Energy e = dynamics::energy(scenario.scene, s);
    largest = std::max(largest, e.kinetic_J + dynamics::magnitude(e.potential_J));
  }
  return relative * static_cast<double>(largest);
}

void append_conservation(const Scenario& scenario, const Truth& truth, const Recording& run, const Observed& all,
                         std::vector<Row>& rows) {
  if (!scenario.scene.problem.empty() || run.values.size() < 2) return;
  append_energy(scenario, truth, run, all, rows);
  if (declares(scenario, "momentum")) append_momentum(scenario, run, rows);
  if (declares(scenario, "angular-momentum") || declares(scenario, "angular-momentum-center"))
    append_angular_momentum(scenario, run, rows);
  if (declares(scenario, "center-of-mass")) append_center_of_mass(scenario, run, rows);
  if (declares(scenario, "laplace-runge-lenz")) append_orbit_vector(scenario, run, rows);
  if (declares(scenario, "magnetic-moment")) append_magnetic_moment(scenario, run, rows);
  if (declares(scenario, "swinging-atwood")) append_swinging_atwood(scenario, run, rows);
}

}  // namespace atwood::metrics
