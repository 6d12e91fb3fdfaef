#include <algorithm>
#include <cmath>

#include "cvode/bars.hpp"
#include "cvode/mechanism.hpp"
#include "dynamics/arithmetic.hpp"
#include "dynamics/certified_end.hpp"
#include "mechanism/maximal.hpp"
#include "mechanism/reduced.hpp"
#include "mechanism/start.hpp"
#include "mechanism/values.hpp"
#include "protocol/refusal.hpp"
#include "scene/mechanism.hpp"

namespace atwood::cvode {

namespace {

constexpr int kManyRates = 40;              // with more, a Newton matrix costs more than it saves
constexpr double kPartsRoundOff = 0x1p-48;  // 16 units in the last place of double
constexpr double kContradiction = 1e-9;     // of the size: constraints that projected poses violate by more

struct Run {
  SampleSeries samples;
  Outcome outcome;
  double end_s = HUGE_VAL;
};

// Sizes of the values at the start; for quantities at rest, estimated from the accelerations.
Scales scales_of(const Scenario& scenario, const Sample& start) {
  mechanism::Reduced<double> motion(scenario.scene, scenario.t_end_s, start);
  const std::vector<double> y = motion.initial(start);
  motion.choose(0, y.data());
  std::vector<double> f(y.size());
  motion.rate(0, y.data(), f.data());
  Scales made;
  double length = 0, speed = 0, angular_rate = 0, acceleration = 0, angular_acceleration = 0;
  for (const Joint& joint : scenario.scene.joints)
    for (const auto& anchor : joint.anchors_body_m)
      for (const double x : anchor) length = std::max(length, std::fabs(x));
  const int first_rate = motion.coordinate_count();
  for (int k = 0; k < motion.size(); ++k) {
    const int group = motion.groups()[k];
    if (group == 0) length = std::max(length, std::fabs(y[k]));
    if (k < first_rate) continue;
    (group == 3 ? speed : angular_rate) = std::max(group == 3 ? speed : angular_rate, std::fabs(y[k]));
    (group == 3 ? acceleration : angular_acceleration) =
        std::max(group == 3 ? acceleration : angular_acceleration, std::fabs(f[k]));
  }
  if (length > 0) made.position_m = length;
  made.velocity_m_per_s =
      std::max({speed, std::sqrt(acceleration * made.position_m), made.position_m / scenario.t_end_s});
  made.rate_rad_per_s = std::max({angular_rate, std::sqrt(angular_acceleration), 1 / scenario.t_end_s});
  return made;
}

Run solve(const Scenario& scenario, std::int64_t samples, Family family, double rtol, const Scales& scales,
          bool newton) {
  Options options;
  options.scales = scales;
  options.family = family;
  options.rtol = rtol;
  options.atol = rtol / 100;
  options.max_order = family == Family::adams ? 12 : 5;
  options.newton = newton;
  Run made;
  made.outcome = run_mechanism(scenario.scene, scenario.t_end_s, samples, options,
                               {[&](const Sample& s) { made.samples.push_back(s); }, {}}, nullptr,
                               Coverage::constraints, &made.end_s);
  if (made.outcome.status != Status::ok)
    made.outcome.reason +=
        std::string(" (") + (family == Family::adams ? "Adams" : "BDF") + " at rtol " + format_double(rtol) + ")";
  return made;
}

// Which components of the reactions the constraints determine: from the rank of all constraints, in quad, at the poses
// moved onto them. False: at a sample they could not be moved there.
bool mark_not_unique(const Scenario& scenario, double size_m, const Sample& start, SampleSeries& values) {
  const Scene& scene = scenario.scene;
  if (std::none_of(scene.joints.begin(), scene.joints.end(), [](const Joint& joint) { return joint.closes_loop; }))
    return true;
  mechanism::Maximal<Wide> maximal(scene, scenario.t_end_s, start);
  std::vector<Wide> y = maximal.initial(start);
  maximal.choose(0, y.data());
  for (const SampleReference value : values) {
    y = maximal.initial(copy_of(value));
    if (!(maximal.project(value.t_s, y.data()) <= Wide(kContradiction) * size_m)) return false;
    maximal.choose(value.t_s, y.data());
    const Sample marked = maximal.sample(value.t_s, y.data());
    for (std::size_t j = 0; j < value.joints.size(); ++j) value.joints[j].not_unique = marked.joints[j].not_unique;
  }
  return true;
}

// A value that has been 0 in all runs, as a rate about an axis that the joints leave no freedom, shares no difference
// of its kind. Velocities are sums of parts of the size of those of the scene, which may cancel: they have the
// round-off of these.
void add_bars(const Scene& scene, const std::vector<Run>& runs, const Scales& natural, Truth& truth) {
  using namespace mechanism;
  const std::vector<Wide> scale = scales(scene, truth.values);
  std::vector<Wide> farthest(kinds, Wide(0)), round_off(kinds, Wide(0));
  round_off[velocity] = round_off[rate_speed] = kPartsRoundOff * natural.velocity_m_per_s;
  round_off[angular_velocity] = round_off[coordinate_rate_angular] = kPartsRoundOff * natural.rate_rad_per_s;
  std::vector<char> moved;  // of each value
  for (std::size_t k = 0; k < truth.values.size(); ++k) {
    const std::vector<char> undetermined = undetermined_values(scene, truth.values[k]);
    for (std::size_t a = 0; a < runs.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        const std::vector<Wide> difference = differences(scene, runs[a].samples[k], {runs[b].samples[k]});
        std::size_t i = 0;
        each_value(scene, truth.values[k], [&](const Wide& x, ValueKind kind) {
          if (!undetermined[i]) farthest[kind] = std::max(farthest[kind], difference[i]);
          if (moved.size() == i) moved.push_back(0);
          moved[i] = moved[i] || x != 0 || difference[i] != 0;
          ++i;
        });
      }
    truth.bars.push_back(truth.values[k]);
    const SampleReference bar = truth.bars.back();
    std::size_t i = 0;
    each_value(scene, bar, [&](Wide& x, ValueKind kind) {
      const Wide apart = moved[i] ? kSafety * farthest[kind] : Wide(0);
      x = undetermined[i++] ? Wide(0) : apart + Wide(kRelativeFloor) * scale[kind] + round_off[kind];
    });
  }
}

}  // namespace

Truth mechanism_truth(const Scenario& scenario, std::int64_t samples) {
  Truth truth;
  const auto refuse = [&](const std::string& why) {
    truth.outcome = refused("CVODE: " + why);
    return truth;
  };
  for (const std::string& why : {mechanism::unsupported(scenario.scene), dynamics::unsupported(scenario.scene)})
    if (!why.empty()) return refuse(why);
  if (!(scenario.t_end_s > 0) || samples < 1) return refuse("nothing to run");
  Sample start;
  try {
    start = mechanism::start_sample(scenario.scene);
  } catch (const MechanismError& error) {
    return refuse(error.what());
  }
  const Scales scales = scales_of(scenario, start);
  const bool newton = mechanism::Reduced<double>(scenario.scene, scenario.t_end_s, start).rate_count() <= kManyRates;
  std::vector<Run> runs;
  double end_s = HUGE_VAL;
  std::size_t rows = static_cast<std::size_t>(samples) + 1;
  for (const double rtol : {kTightRtol, kLooseRtol})
    for (const Family family : {Family::adams, Family::bdf}) {
      runs.push_back(solve(scenario, samples, family, rtol, scales, newton));
      const Run& run = runs.back();
      truth.outcome.steps_taken += run.outcome.steps_taken;
      truth.outcome.rate_evaluations += run.outcome.rate_evaluations;
      rows = std::min(rows, run.samples.size());
      if (run.outcome.status == Status::ok) continue;
      if (run.end_s == HUGE_VAL) {  // a failure of the solver: nothing is certified
        truth.outcome.status = run.outcome.status;
        truth.outcome.reason = run.outcome.reason;
        return truth;
      }
      if (run.end_s < end_s) {
        end_s = run.end_s;
        truth.outcome.status = run.outcome.status;
        truth.outcome.reason = run.outcome.reason;
      }
    }
  const auto certified = [&](const SampleView& row) {
    return row.t_s == 0 || static_cast<double>(row.t_s) < end_s * (1 - dynamics::kEndMargin);
  };
  while (rows > 0 && !certified(runs.front().samples[rows - 1])) --rows;
  truth.values = runs.front().samples;
  truth.values.truncate(rows);
  if (!mark_not_unique(scenario, scales.position_m, start, truth.values))
    return refuse(
        "which reactions the constraints determine is not known: Newton's method does not satisfy them together");
  add_bars(scenario.scene, runs, scales, truth);
  truth.source =
      "cvode: SUNDIALS " + version() +
      " in the coordinates of a spanning tree, Adams at rtol 1e-12; bar: twice the largest difference of its "
      "kind, so far in the run, among Adams and BDF at rtol 1e-12 and 1e-10 (atol = rtol / 100 of each kind's "
      "size), plus 1e-13 of the scale";
  truth.note = "CVODE's own differences: wider than a certified truth's bar";
  return truth;
}

}  // namespace atwood::cvode
