// The error by round-off alone, estimated before a run: the amplification of perturbations by the motion times the
// perturbation by rounding.
#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "dynamics/contacts.hpp"
#include "dynamics/rates.hpp"
#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

using dynamics::Kind;
constexpr double kPerturbation = 1e-7;
constexpr std::array<unsigned, 4> kTwins = {0, 1, 2, 4};  // rows of the Walsh matrix

using State = std::vector<double>;

double norm_of(Kind kind, const dynamics::Layout& layout, const State& y) {
  double sum = 0;
  for (int i = 0; i < layout.size; ++i)
    if (layout.kinds[i] == kind) sum += y[i] * y[i];
  return std::sqrt(sum);
}

// Moves every component by 1e-7 of its vector's norm. The signs are rows of a Walsh matrix: two components whose
// indices differ in a bit get equal signs in one twin and opposite signs in another.
State perturbed(const dynamics::Layout& layout, const State& y, unsigned row) {
  State z = y;
  for (int i = 0; i < layout.size;) {
    const int width = layout.kinds[i] == Kind::attitude ? 4 : 3;
    double size = 0;
    for (int j = i; j < i + width && j < layout.size; ++j) size += y[j] * y[j];
    for (int j = i; j < i + width && j < layout.size; ++j)
      z[j] += (std::popcount(static_cast<unsigned>(j) & row) % 2 ? -1 : 1) * kPerturbation * std::sqrt(size / width);
    i += width;
  }
  return z;
}

struct Sizes {
  double position = 0, velocity = 0, rate = 0;
};
Sizes sizes(const Scenario& scenario, const Truth& truth) {
  std::vector<Row> rows;
  metrics::append_sizes(scenario, truth, rows);
  Sizes s;
  for (const Row& r : rows) {
    if (r.metric == "size-position") s.position = r.value;
    if (r.metric == "size-velocity") s.velocity = r.value;
    if (r.metric == "size-body-rate") s.rate = r.value;
  }
  return s;
}

double free_flight_growth(const Sizes& s, double t_end_s) {
  const double shear = s.position > 0 ? s.velocity / s.position : 0;
  return 1 + t_end_s * std::max(shear, s.rate);
}

}  // namespace

void metrics::reference_step(const dynamics::Dynamics<double>& f, double t, double h, std::vector<double>& y,
                             std::array<std::vector<double>, 5>& work) {
  const int interval = f.interval_at(t + h / 2);
  auto& [k1, k2, k3, k4, z] = work;
  const auto stage = [&, &z = z](double c, const std::vector<double>& k) {
    for (std::size_t i = 0; i < y.size(); ++i) z[i] = y[i] + c * h * k[i];
  };
  f.rate(t, y.data(), k1.data(), interval);
  stage(0.5, k1);
  f.rate(t + h / 2, z.data(), k2.data(), interval);
  stage(0.5, k2);
  f.rate(t + h / 2, z.data(), k3.data(), interval);
  stage(1, k3);
  f.rate(t + h, z.data(), k4.data(), interval);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
}

namespace {

constexpr std::int64_t kFewestSteps = 1000, kCoarseSteps = 4000;
constexpr double kMaxRefinedWork = 2e7;  // of refined runs: steps x (bodies^2 + 4), some 4 s

// The growth by a run of this many steps; nothing where the run does not end where the truth does, for it then shows
// the step's error. The states are compared at 4000 instants or a few more.
std::optional<double> growth_by(const Scenario& scenario, const Truth& truth, std::int64_t steps) {
  const Scene& scene = scenario.scene;
  const dynamics::Dynamics<double> f(scene, scenario.t_end_s);
  const dynamics::Layout& layout = f.layout();
  const double h = scenario.t_end_s / static_cast<double>(steps);
  std::vector<State> twins{dynamics::pack<double>(scene)};
  for (unsigned row : kTwins) twins.push_back(perturbed(layout, State(twins[0]), row));
  std::array<State, 5> work;
  for (State& w : work) w.assign(twins[0].size(), 0.0);
  State d = twins[0];
  std::array<double, 4> size{}, apart{};
  const std::array<Kind, 4> kinds{Kind::position, Kind::velocity, Kind::attitude, Kind::rate};
  const std::int64_t stride = std::max<std::int64_t>(1, steps / kCoarseSteps);
  for (std::int64_t n = 0; n < steps; ++n) {
    for (State& y : twins) metrics::reference_step(f, h * static_cast<double>(n), h, y, work);
    if ((n + 1) % stride != 0 && n + 1 < steps) continue;
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      size[k] = std::max(size[k], norm_of(kinds[k], layout, twins[0]));
      for (std::size_t i = 1; i < twins.size(); ++i) {
        for (std::size_t j = 0; j < d.size(); ++j) d[j] = twins[i][j] - twins[0][j];
        apart[k] = std::max(apart[k], norm_of(kinds[k], layout, d));
      }
    }
  }
  const Sample end = dynamics::unpack<double>(scene, scenario.t_end_s, twins[0].data());
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const BodySample& t = truth.values.back().bodies[b];
    if (!(position_error_m(end.bodies[b], t) <= 0.01 * size[0]) || !(attitude_error_rad(end.bodies[b], t) <= 0.02))
      return {};
  }
  double growth = 1;
  for (std::size_t k = 0; k < kinds.size(); ++k)
    if (size[k] > 0) growth = std::max(growth, apart[k] / size[k] / kPerturbation);
  return growth;
}

}  // namespace

PerturbationGrowth perturbation_growth(const Scenario& scenario, const Truth& truth) {
  if (!metrics::has_truth(truth)) return {0, true};
  const Scene& scene = scenario.scene;
  const double simple = free_flight_growth(sizes(scenario, truth), scenario.t_end_s);
  if (has_mechanism(scene)) return {std::max(simple, truth.condition), true};
  if (!dynamics::unsupported(scene).empty() || dynamics::contacts_possible(scene)) return {simple, false};
  std::int64_t steps = kFewestSteps;
  for (std::int64_t n : scenario.steps) steps = std::max(steps, std::min(n, kCoarseSteps));
  // A bare problem has no positions or velocities whose growth could be measured.
  if (const auto growth = growth_by(scenario, truth, steps)) return {*growth, scene.problem.empty()};
  const auto bodies = static_cast<double>(scene.bodies.size());
  for (steps = 4 * kCoarseSteps; static_cast<double>(steps) * (bodies * bodies + 4) <= kMaxRefinedWork; steps *= 4)
    if (const auto growth = growth_by(scenario, truth, steps)) return {*growth, true};
  return {simple, false};
}

double metrics::state_horizon_s(const Scenario& scenario, const Truth& truth) {
  const Scene& scene = scenario.scene;
  const bool chaotic = std::find(scenario.tags.begin(), scenario.tags.end(), "chaotic") != scenario.tags.end();
  if (!chaotic || !has_truth(truth) || has_mechanism(scene) || !dynamics::unsupported(scene).empty() ||
      dynamics::contacts_possible(scene))
    return scenario.t_end_s;
  const dynamics::Dynamics<double> f(scene, scenario.t_end_s);
  std::int64_t steps = 1000;
  for (std::int64_t n : scenario.steps) steps = std::max(steps, std::min<std::int64_t>(n, 100000));
  const double h = scenario.t_end_s / static_cast<double>(steps);
  State y = dynamics::pack<double>(scene), twin = perturbed(f.layout(), State(y), kTwins[1]);
  for (std::size_t i = 0; i < y.size(); ++i) twin[i] = y[i] + 1e-10 / kPerturbation * (twin[i] - y[i]);
  std::array<State, 5> work;
  for (State& w : work) w.assign(y.size(), 0.0);
  double size = 0;
  for (std::int64_t n = 0; n < steps; ++n) {
    metrics::reference_step(f, h * static_cast<double>(n), h, y, work);
    metrics::reference_step(f, h * static_cast<double>(n), h, twin, work);
    State d = twin;
    for (std::size_t i = 0; i < d.size(); ++i) d[i] -= y[i];
    size = std::max(size, norm_of(Kind::position, f.layout(), y));
    if (!(norm_of(Kind::position, f.layout(), d) < 1e-3 * size)) return h * static_cast<double>(n + 1);
  }
  return scenario.t_end_s;
}

double round_off_floor(double unit, double steps, double size, double amplification) {
  return unit * std::sqrt(steps) * size * amplification;
}

double metrics::recorded_unit_round_off(const Scene& scene, const Recording& run) {
  double unit = 0x1p-24;
  const auto take = [&](Wide x) {
    if (x == Wide(static_cast<float>(x))) return;
    if (x == Wide(static_cast<double>(x))) unit = std::min(unit, 0x1p-53);
    else unit = std::min(unit, x == Wide(static_cast<long double>(x)) ? 0x1p-64 : 0x1p-113);
  };
  for (std::size_t k = 1; k < run.values.size(); ++k)
    for (std::size_t b = 0; b < run.values[k].bodies.size() && b < scene.bodies.size(); ++b) {
      if (scene.bodies[b].fixed) continue;
      for (Wide x : run.values[k].bodies[b].p_m) take(x);
      for (Wide x : run.values[k].bodies[b].v_m_per_s) take(x);
    }
  return unit;
}

double unit_round_off(const std::string& method) {
  const std::size_t at = method.find('@');
  const std::string engine = method.substr(0, method.find('/'));
  const std::string scalar = at == std::string::npos ? "" : method.substr(at + 1, method.find('{', at) - at - 1);
  if (scalar == "float") return 0x1p-24;
  if (scalar == "long-double") return 0x1p-64;
  if (scalar == "quad") return 0x1p-113;
  if (scalar.empty() && engine.size() > 2 && engine.ends_with("32")) return 0x1p-24;
  return 0x1p-53;
}

}  // namespace atwood
