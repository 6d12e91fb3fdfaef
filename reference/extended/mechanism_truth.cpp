#include "extended/mechanism_truth.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "dynamics/rates.hpp"
#include "extended/bars.hpp"
#include "extended/mechanism_path.hpp"
#include "mechanism/start.hpp"
#include "mechanism/values.hpp"
#include "scene/mechanism.hpp"

namespace atwood {

namespace {

using namespace extended;
using namespace mechanism;
using dynamics::at_time;
using dynamics::CertifiedEnd;
using dynamics::end_at;
using dynamics::magnitude;

constexpr double kQuadRoundOff = 1e-32;  // the matrices of constraints cost a digit
constexpr double kSameEvent = 1e-7;      // of the run: events of two runs that are the same
// With more rates than these the run at the larger tolerance is left out, and the tolerance is larger.
constexpr int kManyRates = 12, kVeryManyRates = 40;
// Without stops, of which the impacts are located in quad, the spanning tree of so many rates is stepped in long
// double, at a tolerance above its round-off. The values are then those of the maximal coordinates.
constexpr double kLongDoubleTolerance = 3e-16, kVeryManyRatesTolerance = 1e-15, kMaximalTolerance = 1e-17;
// Where two runs alone are compared, two errors may agree by chance: no bar is less than this part of the largest
// difference of its kind so far.
constexpr double kShareOfLargest = 0.1;

constexpr double kConditionTolerance = 1e-12, kPerturbation = 1e-9;
constexpr int kMaxPerturbations = 24;

struct Trial {
  MechanismPath tight, loose, maximal;  // the values are those of `tight`, marked as those of `maximal`
  bool two_runs = false;                // one of the three stands for two
};

struct Bars {
  SampleSeries samples;
  std::vector<double> events_s;
  double largest = 0;
  std::size_t bounded = 0, certified = 0;
  std::optional<CertifiedEnd> end;
};

// The first time at which one run has an event that another lacks, or failed. Low bounces that one run sums and another
// still has are not a difference: the other has come to rest there.
std::optional<CertifiedEnd> find_end(const Trial& trial, double t_end_s) {
  std::optional<CertifiedEnd> end;
  const MechanismPath* paths[] = {&trial.tight, &trial.loose, &trial.maximal};
  for (const MechanismPath* path : paths)
    if (!path->failure.empty()) end_at(end, path->end_s, path->failure);
  const Wide near = Wide(kSameEvent) * Wide(t_end_s);
  for (const MechanismPath* one : paths)
    for (const Event& event : one->events)
      for (const MechanismPath* other : paths) {
        if (event.t_s + near > other->end_s) continue;
        const bool found = std::any_of(other->events.begin(), other->events.end(), [&](const Event& e) {
          return e.body_a == event.body_a && e.body_b == event.body_b &&
                 (e.kind == event.kind || e.kind == EventKind::rest) && magnitude(e.t_s - event.t_s) <= near;
        });
        if (!found) end_at(end, event.t_s, "the runs disagree on the stop of a joint" + at_time(event.t_s));
      }
  return end;
}

Bars compare(const Scenario& scenario, std::int64_t samples, const Trial& trial) {
  const Scene& scene = scenario.scene;
  Bars made;
  made.end = find_end(trial, scenario.t_end_s);
  const std::vector<Wide> scale = scales(scene, trial.tight.samples);
  const std::size_t count =
      std::min({trial.tight.samples.size(), trial.loose.samples.size(), trial.maximal.samples.size()});
  made.bounded = made.certified = count;
  std::vector<Wide> farthest(kinds, Wide(0));  // of each kind, so far
  std::vector<char> moved;                     // of each value: it has not been 0 in all runs
  for (std::size_t k = 0; k < count; ++k) {
    const Wide t = Wide(scenario.t_end_s) * Wide(static_cast<double>(k)) / Wide(static_cast<double>(samples));
    if (made.certified == count && made.end && k > 0 && !made.end->is_after(t)) made.certified = k;
    Sample marked = copy_of(trial.tight.samples[k]);
    for (std::size_t j = 0; j < marked.joints.size(); ++j)
      marked.joints[j].not_unique = trial.maximal.samples[k].joints[j].not_unique;
    const std::vector<char> open = undetermined_values(scene, marked);
    const std::vector<Wide> apart =
        differences(scene, trial.tight.samples[k], {trial.loose.samples[k], trial.maximal.samples[k]});
    std::size_t i = 0;
    each_value(scene, marked, [&](const Wide& x, ValueKind kind) {
      if (!open[i]) farthest[kind] = std::max(farthest[kind], apart[i]);
      if (moved.size() == i) moved.push_back(0);
      moved[i] = moved[i] || x != 0 || apart[i] != 0;
      ++i;
    });
    i = 0;
    each_value(scene, marked, [&](Wide& bar, ValueKind kind) {
      const Wide least = trial.two_runs && moved[i] ? Wide(kShareOfLargest) * farthest[kind] : Wide(0);
      bar = open[i] ? Wide(0) : kBarSafety * std::max(apart[i], least) + Wide(kQuadRoundOff) * scale[kind];
      if (!open[i] && k < made.certified) {
        made.largest = std::max(made.largest, static_cast<double>(bar / scale[kind]));
        if (!(bar <= Wide(kUselessBar) * scale[kind])) made.bounded = std::min(made.bounded, k);
      }
      ++i;
    });
    marked.t_s = t;
    made.samples.push_back(marked);
  }
  for (const Event& event : trial.tight.events) {
    Wide worst = 0;
    for (const MechanismPath* other : {&trial.loose, &trial.maximal}) {
      Wide nearest = -1;
      for (const Event& e : other->events)
        if (e.body_a == event.body_a && e.body_b == event.body_b) {
          const Wide apart = magnitude(e.t_s - event.t_s);
          if (nearest < 0 || apart < nearest) nearest = apart;
        }
      worst = std::max(worst, nearest);
    }
    made.events_s.push_back(static_cast<double>(kBarSafety * worst + Wide(kQuadRoundOff) * event.t_s));
  }
  return made;
}

MechanismPath reduced_path(const Scenario& scenario, std::int64_t samples, const Sample& start, double tolerance,
                           double rest_span, Arithmetic arithmetic, Grid grid) {
  const Scene& scene = scenario.scene;
  const auto motion = reduced_motion(scene, scenario.t_end_s, start, arithmetic);
  return integrate_mechanism(*motion, start,
                             {scene, scenario.t_end_s, samples, tolerance, rest_span * scenario.t_end_s, grid});
}

MechanismPath maximal_path(const Scenario& scenario, std::int64_t samples, const Sample& start, double tolerance,
                           Grid grid) {
  const Scene& scene = scenario.scene;
  const auto motion = maximal_motion(scene, scenario.t_end_s, start);
  return integrate_mechanism(*motion, start,
                             {scene, scenario.t_end_s, samples, tolerance, 1e-12 * scenario.t_end_s, grid});
}

// As flow_condition() of scenes without joints, over the coordinates and rates of all joints and floating bodies. 0:
// too many of them, or a perturbed motion ended early or has other impacts.
double condition_of(const Scenario& scenario, std::int64_t samples, const Sample& start) {
  const Scene& scene = scenario.scene;
  const auto run = [&](const Sample& from) {
    const auto motion = reduced_motion(scene, scenario.t_end_s, start, Arithmetic::long_double);
    return integrate_mechanism(*motion, from, {scene, scenario.t_end_s, samples, kConditionTolerance, 1e-9});
  };
  const MechanismPath base = run(start);
  if (!base.failure.empty()) return 0;
  const std::vector<Wide> scale = scales(scene, base.samples);
  const std::vector<int> placing = placing_joints(scene);
  std::vector<char> is_start, is_motion;  // of each number of the start, of a sample (which has ropes besides)
  Sample marks = start;
  each_value(scene, marks, [](Wide& x, ValueKind) { x = 0; });
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].fixed && placing[i] < 0) {
      marks.bodies[i].p_m.fill(1), marks.bodies[i].v_m_per_s.fill(1);
      if (rotates(scene.bodies[i])) marks.bodies[i].q_wxyz.fill(1), marks.bodies[i].w_rad_per_s.fill(1);
    }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    if (joint.closes_loop || joint.driven_rate) continue;
    std::fill_n(marks.joints[j].q.begin(), coordinate_count(joint.kind), Wide(1));
    std::fill_n(marks.joints[j].u.begin(), rate_count(joint.kind), Wide(1));
  }
  each_value(scene, marks, [&](const Wide& x, ValueKind) { is_start.push_back(x != 0); });
  each_value(scene, base.samples.front(), [&](const Wide&, ValueKind kind) { is_motion.push_back(kind < force); });
  if (std::count(is_start.begin(), is_start.end(), 1) > kMaxPerturbations) return 0;
  const auto events_until = [](const MechanismPath& path, Wide t_s) {
    return std::count_if(path.events.begin(), path.events.end(), [&](const Event& e) { return e.t_s <= t_s; });
  };
  std::vector<std::vector<double>> growth(base.samples.size(), std::vector<double>(is_motion.size(), 0.0));
  for (std::size_t perturbed = 0; perturbed < is_start.size(); ++perturbed) {
    if (!is_start[perturbed]) continue;
    Sample from = start;
    std::size_t i = 0;
    each_value(scene, from, [&](Wide& x, ValueKind kind) {
      if (i++ == perturbed) x += Wide(kPerturbation) * scale[kind];
    });
    const MechanismPath path = run(from);
    if (path.samples.size() != base.samples.size() || path.events.size() != base.events.size()) return 0;
    for (std::size_t k = 1; k < base.samples.size(); ++k) {
      if (events_until(base, base.samples[k].t_s) != events_until(path, base.samples[k].t_s)) continue;
      const std::vector<Wide> moved = differences(scene, base.samples[k], {path.samples[k]});
      i = 0;
      each_value(scene, base.samples[k], [&](const Wide&, ValueKind kind) {
        if (is_motion[i]) growth[k][i] += static_cast<double>(moved[i] / (Wide(kPerturbation) * scale[kind]));
        ++i;
      });
    }
  }
  double largest = 0;
  for (const auto& row : growth) largest = std::max(largest, *std::max_element(row.begin(), row.end()));
  return std::isfinite(largest) ? largest : 0;
}

Trial attempt(const Scenario& scenario, std::int64_t samples, const Sample& start, double tolerance, bool with_loose) {
  Trial made;
  made.tight = reduced_path(scenario, samples, start, tolerance, 1e-12, Arithmetic::quad, Grid::samples);
  made.loose = with_loose ? reduced_path(scenario, samples, start, 1e3 * tolerance, 1e-11, Arithmetic::quad, Grid::free)
                          : made.tight;
  made.maximal = maximal_path(scenario, samples, start, tolerance, with_loose ? Grid::samples : Grid::free);
  made.two_runs = !with_loose;
  return made;
}

// The motion in maximal coordinates, in quad, and that of the spanning tree, in long double.
Trial attempt_large(const Scenario& scenario, std::int64_t samples, const Sample& start, bool very_many) {
  Trial made;
  made.maximal = made.tight = maximal_path(scenario, samples, start, kMaximalTolerance, Grid::samples);
  made.loose = reduced_path(scenario, samples, start, very_many ? kVeryManyRatesTolerance : kLongDoubleTolerance, 1e-12,
                            Arithmetic::long_double, Grid::free);
  made.two_runs = true;
  return made;
}

int tree_rates(const Scene& scene) {
  int rates = 0;
  for (const Joint& joint : scene.joints) rates += joint.closes_loop ? 0 : rate_count(joint.kind);
  return rates;
}

bool has_stops(const Scene& scene) {
  return std::any_of(scene.joints.begin(), scene.joints.end(),
                     [](const Joint& joint) { return joint.limits.has_value(); });
}

std::string in_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1e", value);
  return text;
}

Truth refused_truth(const std::string& reason) {
  Truth made = refused<Truth>(reason);
  made.source = "extended";
  return made;
}

Truth solve(const Scenario& scenario, std::int64_t samples) {
  const Sample start = mechanism::start_sample(scenario.scene);
  Truth truth;
  const int rates = tree_rates(scenario.scene);
  const bool small = rates <= kManyRates, very_many = rates > kVeryManyRates;
  const bool in_long_double = !small && !has_stops(scenario.scene);
  truth.source = in_long_double
                     ? "extended: maximal coordinates by Gauss 20 in quad and spanning tree by GBS 24 in long double"
                     : "extended: spanning tree by GBS 24 and maximal coordinates by Gauss 20, in quad";
  const double tolerance = small ? 1e-27 : very_many ? 1e-20 : 1e-24;
  Trial trial = in_long_double ? attempt_large(scenario, samples, start, very_many)
                               : attempt(scenario, samples, start, tolerance, small);
  Bars bars = compare(scenario, samples, trial);
  if (small && bars.largest > kTargetBar && bars.bounded == bars.certified) {
    Trial closer = attempt(scenario, samples, start, 1e-30, true);
    Bars smaller = compare(scenario, samples, closer);
    if (smaller.certified >= bars.certified && smaller.largest < bars.largest) {
      trial = std::move(closer);
      bars = std::move(smaller);
    }
  }
  if (small) truth.condition = condition_of(scenario, samples, start);
  if (bars.largest > kTargetBar) {
    if (bars.bounded < bars.certified)
      truth.note =
          "not bounded after t = " +
          format_double(scenario.t_end_s * static_cast<double>(bars.bounded - 1) / static_cast<double>(samples)) +
          " s: the methods differ by more than a thousandth of the scale; ";
    truth.note += "bars up to " + in_digits(bars.largest) + " of the scale";
    if (trial.tight.residual > Wide(1e-20))
      truth.note += "; redundant constraints contradict the others by " +
                    in_digits(static_cast<double>(trial.tight.residual)) + ", as the scene's numbers are rounded";
  }
  for (std::size_t k = 0; k < bars.certified; ++k) {
    truth.values.push_back(trial.tight.samples[k]);
    truth.bars.push_back(bars.samples[k]);
    truth.values.back().t_s = truth.bars.back().t_s;
    for (std::size_t j = 0; j < truth.values.back().joints.size(); ++j)
      truth.values.back().joints[j].not_unique = truth.bars.back().joints[j].not_unique;
  }
  append_certified_events(trial.tight.events, bars.events_s, bars.end, truth);
  truth.outcome.steps_taken = trial.tight.steps;
  truth.outcome.rate_evaluations =
      trial.loose.evaluations + trial.maximal.evaluations + (in_long_double ? 0 : trial.tight.evaluations);
  return truth;
}

}  // namespace

Truth mechanism_truth(const Scenario& scenario, std::int64_t samples) {
  const Scene& scene = scenario.scene;
  try {
    for (const std::string& why : {mechanism::unsupported(scene), dynamics::unsupported(scene)})
      if (!why.empty()) return refused_truth(why);
    if (samples < 1 || !(scenario.t_end_s > 0))
      return refused_truth("expected t_end_s > 0 and at least 1 sample; found t_end_s = " +
                           format_double(scenario.t_end_s) + " and " + std::to_string(samples) + " samples");
    return solve(scenario, samples);
  } catch (const MechanismError& error) {
    return refused_truth(error.what());
  }
}

}  // namespace atwood
