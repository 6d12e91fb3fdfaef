// Round-off alone, over many runs: the difference of each from the same run in wider arithmetic from the same doubles,
// in which the error of the method cancels. Where an engine has no wider arithmetic: the difference from the truth, at
// the round-off floor.
#include <algorithm>
#include <cmath>
#include <limits>

#include "protocol/method.hpp"
#include "scene/split_mix.hpp"
#include "validation/metrics/probe_parts.hpp"

namespace atwood::metrics {
namespace {

constexpr int kRuns = 96;

// The number of nonzero coordinates of the initial state.
int coordinates(const Scene& scene) {
  int n = 0;
  for (const Body& body : scene.bodies) {
    if (body.fixed) continue;
    for (const auto& v : {body.position_m, body.velocity_m_per_s, body.angular_velocity_body_rad_per_s})
      n += static_cast<int>(std::count_if(v.begin(), v.end(), [](double x) { return x != 0; }));
  }
  return n;
}

// The largest perturbation of a coordinate in units in the last place: 1, and more where few coordinates would make
// many starts equal. Nearly all of 96 starts drawn from 1000 differ.
int furthest(const Scene& scene) {
  int units = 1;
  const int n = std::max(1, coordinates(scene));
  while (units < 500 && n * std::log(2.0 * units + 1) < std::log(1000.0)) ++units;
  return units;
}

// x moved by a whole number of units in the last place of the method's scalar (double at most: scenes are doubles).
double moved(double x, SplitMix64& random, int units, bool single) {
  const int draw = static_cast<int>(random.next() % static_cast<std::uint64_t>(2 * units + 1)) - units;
  if (x == 0) return x;
  const double towards = draw > 0 ? std::numeric_limits<double>::infinity() : -std::numeric_limits<double>::infinity();
  for (int k = 0; k < std::abs(draw); ++k)
    x = single ? static_cast<double>(std::nextafter(static_cast<float>(x), static_cast<float>(towards)))
               : std::nextafter(x, towards);
  return x;
}

Scene perturbed(const Scene& scene, SplitMix64& random, bool single) {
  Scene changed = scene;
  const int units = furthest(scene);
  for (Body& body : changed.bodies) {
    if (body.fixed) continue;
    for (double& x : body.position_m) x = moved(x, random, units, single);
    for (double& x : body.velocity_m_per_s) x = moved(x, random, units, single);
    for (double& x : body.angular_velocity_body_rad_per_s) x = moved(x, random, units, single);
  }
  return changed;
}

std::string wider(const std::string& method) {
  MethodId id = parse_method_id(method);
  if (id.engine != "atwood" || id.scalar == "quad") return "";
  id.scalar = id.scalar == "float" ? "double" : id.scalar == "long-double" ? "quad" : "long-double";
  return to_string(id);
}

struct Runs {
  std::vector<std::vector<double>> position, attitude, energy;
};

void append(const Scenario& scenario, const EnergyScale& energy_scale, const Recording& run, const SampleSeries& beside,
            const std::vector<double>& energy_beside, Runs& runs) {
  std::vector<double> position, attitude, energy = energy_change(scenario, run, energy_scale);
  for (std::size_t k = 0; k < run.values.size(); ++k) {
    double p = 0, q = 0;
    for (std::size_t b = 0; b < run.values[k].bodies.size(); ++b) {
      if (scenario.scene.bodies[b].fixed) continue;
      p = std::max(p, position_error_m(run.values[k].bodies[b], beside[k].bodies[b]));
      if (rotates(scenario.scene.bodies[b]))
        q = std::max(q, attitude_error_rad(run.values[k].bodies[b], beside[k].bodies[b]));
    }
    position.push_back(p);
    attitude.push_back(q);
  }
  for (std::size_t k = 0; k < energy.size() && k < energy_beside.size(); ++k) energy[k] -= energy_beside[k];
  runs.position.push_back(std::move(position));
  runs.attitude.push_back(std::move(attitude));
  if (!energy.empty()) runs.energy.push_back(std::move(energy));
}

Row growth_row(const std::string& metric, std::span<const double> t, const std::vector<std::vector<double>>& runs,
               const std::string& beside) {
  const GrowthFit fit = fit_growth_ensemble(t, runs);
  const bool named = fit.law != "inconclusive";
  const std::string text = named ? fit.law : "inconclusive: " + fit.reason;
  return row(metric, named ? fit.exponent : std::nan(""), named ? fit.half_width_95 : 0,
             text + "; " + std::to_string(runs.size()) + " runs beside " + beside);
}

// The mean drift over the runs, for round-off, where one run's drift is a single random sample.
Row drift_row(std::span<const double> t, const std::vector<std::vector<double>>& runs, const EnergyScale& scale,
              const std::string& beside) {
  const EnsembleDrift drift = fit_drift_ensemble(t, runs);
  const std::string metric = scale.joules > 0 ? "energy-drift-round-off" : "energy-change-drift-round-off";
  const std::string text = std::to_string(runs.size()) + " runs beside " + beside;
  if (!drift.reason.empty()) return row(metric, std::nan(""), 0, "inconclusive: " + drift.reason + "; " + text);
  const bool none = std::fabs(drift.slope_per_s) <= drift.half_width_95;
  return row(metric, drift.slope_per_s, drift.half_width_95,
             (none                    ? "no drift outside its interval; "
              : drift.slope_per_s > 0 ? "gains energy; "
                                      : "loses energy; ") +
                 text);
}

}  // namespace

std::vector<Row> probe_ensemble(const ProbeRequest& request) {
  require_no_contacts(request);
  const Scenario& scenario = request.scenario;
  const bool single = unit_round_off(request.method) > 1e-10;
  const EnergyScale energy = energy_scale(scenario, request.truth);
  std::string other = wider(request.method);
  Runs runs;
  std::vector<double> t;
  double scale = 0;
  SplitMix64 random{0x656e73656d626c65};
  for (int k = 0; k < kRuns; ++k) {
    const Scene scene = perturbed(scenario.scene, random, single);
    const Recording run = good_run(request, scene, request.plan);
    Recording beside;
    if (!other.empty()) {
      beside = request.run(other, scene, request.plan);
      if (beside.outcome.status != Status::ok && k == 0) other.clear();
      else if (beside.values.size() != run.values.size()) throw ProbeEnds(beside.outcome.status, beside.outcome.reason);
    }
    if (other.empty()) {
      if (!has_truth(request.truth) || request.truth.values.size() != run.values.size())
        throw ProbeEnds(Status::unsupported, "neither wider arithmetic nor a truth to compare with");
      beside.values = request.truth.values;
    }
    if (t.empty()) {
      for (const SampleView s : run.values) t.push_back(static_cast<double>(s.t_s));
      scale = sizes_of(scenario.scene, run.values).position_m;
    }
    append(scenario, energy, run, beside.values,
           other.empty() ? std::vector<double>{} : energy_change(scenario, beside, energy), runs);
  }
  const std::string beside = other.empty() ? "the truth" : other;
  std::vector<Row> rows;
  if (!runs.energy.empty()) rows.push_back(growth_row("growth-exponent-round-off-energy", t, runs.energy, beside));
  if (!runs.energy.empty()) rows.push_back(drift_row(t, runs.energy, energy, beside));
  const bool moves = scale > 0;
  if (moves) rows.push_back(growth_row("growth-exponent-round-off-position", t, runs.position, beside));
  const bool turns =
      std::any_of(scenario.scene.bodies.begin(), scenario.scene.bodies.end(), [](const Body& b) { return rotates(b); });
  if (turns) rows.push_back(growth_row("growth-exponent-round-off-attitude", t, runs.attitude, beside));
  if (!moves) return rows;
  double squares = 0;
  for (const auto& p : runs.position) squares += p.back() * p.back() / kRuns;
  rows.push_back(
      row("round-off-rms-position", std::sqrt(squares), 0, "of a motion of " + format_measure(scale, 0) + " m"));
  return rows;
}

}  // namespace atwood::metrics
