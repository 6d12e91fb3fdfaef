// Round-off alone, over many runs: the difference of each from the same run in wider arithmetic from the same doubles,
// in which the error of the method and the perturbation of the start cancel. An engine without wider arithmetic is
// refused: beside the truth its runs would show the error of its method and the perturbation as well.
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

// The method in wider arithmetic; empty where there is none.
std::string wider(const std::string& method) {
  MethodId id = parse_method_id(method);
  if (id.engine != "atwood" || id.scalar == "quad") return "";
  id.scalar = id.scalar == "float" ? "double" : id.scalar == "long-double" ? "quad" : "long-double";
  return to_string(id);
}

struct Runs {
  std::vector<std::vector<double>> position, attitude, energy;
};

void append(const Scenario& scenario, const EnergyScale& energy_scale, const Recording& run, const Recording& beside,
            Runs& runs) {
  std::vector<double> position, attitude, energy = energy_change(scenario, run, energy_scale);
  const std::vector<double> energy_beside = energy_change(scenario, beside, energy_scale);
  for (std::size_t k = 0; k < run.values.size(); ++k) {
    double p = 0, q = 0;
    for (std::size_t b = 0; b < run.values[k].bodies.size(); ++b) {
      if (scenario.scene.bodies[b].fixed) continue;
      p = std::max(p, position_error_m(run.values[k].bodies[b], beside.values[k].bodies[b]));
      if (rotates(scenario.scene.bodies[b]))
        q = std::max(q, attitude_error_rad(run.values[k].bodies[b], beside.values[k].bodies[b]));
    }
    position.push_back(p);
    attitude.push_back(q);
  }
  for (std::size_t k = 0; k < energy.size() && k < energy_beside.size(); ++k) energy[k] -= energy_beside[k];
  runs.position.push_back(std::move(position));
  runs.attitude.push_back(std::move(attitude));
  if (!energy.empty()) runs.energy.push_back(std::move(energy));
}

const char* const kInseparable =
    ": round-off cannot be told from the error of the method and from the perturbation of the start";

// The same run in wider arithmetic.
Recording run_beside(const ProbeRequest& request, const std::string& other, const Scene& scene) {
  Recording run = request.run(other, scene, request.plan);
  if (run.outcome.status != Status::ok)
    throw ProbeEnds(run.outcome.status,
                    "`" + other + "` has no run to compare with (" + run.outcome.reason + ")" + kInseparable);
  return run;
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
  const std::string other = wider(request.method);
  if (other.empty())
    throw ProbeEnds(Status::unsupported, "`" + request.method + "` has no wider arithmetic" + kInseparable);
  Runs runs;
  std::vector<double> t;
  double scale = 0;
  SplitMix64 random{0x656e73656d626c65};
  for (int k = 0; k < kRuns; ++k) {
    const Scene scene = perturbed(scenario.scene, random, single);
    const Recording run = good_run(request, scene, request.plan);
    const Recording beside = run_beside(request, other, scene);
    if (beside.values.size() != run.values.size())
      throw ProbeEnds(Status::crashed, "`" + other + "` has " + std::to_string(beside.values.size()) + " samples, `" +
                                           request.method + "` " + std::to_string(run.values.size()));
    if (t.empty()) {
      for (const SampleView s : run.values) t.push_back(static_cast<double>(s.t_s));
      scale = sizes_of(scenario.scene, run.values).position_m;
    }
    append(scenario, energy, run, beside, runs);
  }
  std::vector<Row> rows;
  if (!runs.energy.empty()) rows.push_back(growth_row("growth-exponent-round-off-energy", t, runs.energy, other));
  if (!runs.energy.empty()) rows.push_back(drift_row(t, runs.energy, energy, other));
  const bool moves = scale > 0;
  if (moves) rows.push_back(growth_row("growth-exponent-round-off-position", t, runs.position, other));
  const bool turns =
      std::any_of(scenario.scene.bodies.begin(), scenario.scene.bodies.end(), [](const Body& b) { return rotates(b); });
  if (turns) rows.push_back(growth_row("growth-exponent-round-off-attitude", t, runs.attitude, other));
  if (!moves) return rows;
  double squares = 0;
  for (const auto& p : runs.position) squares += p.back() * p.back() / kRuns;
  rows.push_back(
      row("round-off-rms-position", std::sqrt(squares), 0, "of a motion of " + format_measure(scale, 0) + " m"));
  return rows;
}

}  // namespace atwood::metrics
