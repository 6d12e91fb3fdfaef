#include "extended/mechanism_truth.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <optional>

#include "dynamics/rates.hpp"
#include "extended/mechanism_path.hpp"
#include "mechanism/start.hpp"
#include "scene/mechanism.hpp"

namespace atwood {

namespace {

using namespace extended;
using dynamics::magnitude;

constexpr double kTargetBar = 1e-20;  // of the scale
constexpr double kUselessBar = 1e-3;  // relative to the scale: values with larger bars are not bounded
constexpr double kBarSafety = 2;
constexpr double kQuadRoundOff = 1e-32;  // the matrices of constraints cost a digit
constexpr double kEndMargin = 1e-9;      // of the time: distance of the last sample from the end of the certified part
constexpr double kSameEvent = 1e-7;      // of the run: events of two runs that are the same
// With more rates than these the run at the larger tolerance is left out, and the tolerance is larger.
constexpr int kManyRates = 12, kVeryManyRates = 40;
// Without stops, of which the impacts are located in quad, the spanning tree of so many rates is stepped in long double, at
// a tolerance above its round-off. The values are then those of the maximal coordinates.
constexpr double kLongDoubleTolerance = 3e-16, kVeryManyRatesTolerance = 1e-15, kMaximalTolerance = 1e-17;
// Where two runs alone are compared, two errors may agree by chance: no bar is less than this part of the largest difference
// of its kind so far.
constexpr double kShareOfLargest = 0.1;

enum ValueKind {
  position,
  attitude,
  velocity,
  turning,
  coordinate_angle,
  coordinate_length,
  rate_turning,
  rate_speed,
  force,
  torque,
  applied,
  tension,
  pulley,
  kinds
};

// Calls value(number, kind, whether its sign belongs to a quaternion of 4) for every number of a sample, in a fixed order.
template <class SampleType, class Value> void each_value(const Scene& scene, SampleType& sample, Value value) {
  for (auto& body : sample.bodies) {
    for (auto& x : body.p_m) value(x, position);
    for (auto& x : body.q_wxyz) value(x, attitude);
    for (auto& x : body.v_m_per_s) value(x, velocity);
    for (auto& x : body.w_rad_per_s) value(x, turning);
  }
  for (std::size_t j = 0; j < sample.joints.size(); ++j) {
    const JointKind kind = scene.joints[j].kind;
    auto& joint = sample.joints[j];
    const auto slides = [&](int k) { return kind == JointKind::slider || (kind == JointKind::cylindrical && k == 1); };
    for (int k = 0; k < 4; ++k)
      value(joint.q[k], kind == JointKind::ball ? attitude : slides(k) ? coordinate_length : coordinate_angle);
    for (int k = 0; k < 3; ++k) value(joint.u[k], slides(k) ? rate_speed : rate_turning);
    for (auto& x : joint.force_N) value(x, force);
    for (auto& x : joint.torque_N_m) value(x, torque);
    for (auto& x : joint.applied) value(x, applied);
  }
  for (auto& rope : sample.ropes) {
    value(rope.tension_N, tension);
    for (auto& x : rope.pulley_angle_rad) value(x, pulley);
  }
}

std::vector<Wide> values_of(const Scene& scene, const Sample& sample) {
  std::vector<Wide> made;
  each_value(scene, sample, [&](const Wide& x, ValueKind) { made.push_back(x); });
  return made;
}

// Bits of not_unique as flags of the same order: true: the value is open.
std::vector<char> open_values(const Scene& scene, const Sample& sample) {
  Sample marks = sample;
  each_value(scene, marks, [](Wide& x, ValueKind) { x = 0; });
  for (JointSample& joint : marks.joints)
    for (int k = 0; k < 3; ++k) {
      joint.force_N[k] = (joint.not_unique >> k) & 1u;
      joint.torque_N_m[k] = (joint.not_unique >> (k + 3)) & 1u;
    }
  std::vector<char> made;
  each_value(scene, marks, [&](const Wide& x, ValueKind) { made.push_back(x != 0); });
  return made;
}

struct Trial {
  MechanismPath tight, loose, maximal;  // the values are those of `tight`, marked as those of `maximal`
  bool two_runs = false;                // one of the three stands for two
};

struct End {
  Wide t_s = 0;
  std::string why;
};

struct Bars {
  std::vector<Sample> samples;
  std::vector<double> events_s;
  double largest = 0;
  std::size_t bounded = 0, certified = 0;
  std::optional<End> end;
};

std::string at_time(Wide t_s) { return " at t = " + format_double(static_cast<double>(t_s)) + " s"; }

void end_at(std::optional<End>& end, Wide t_s, const std::string& why) {
  if (!end || t_s < end->t_s) end = End{t_s, why};
}

// The first time at which one run has an event that another lacks, or failed. Low bounces that one run sums and another
// still has are no difference: the other has come to rest there.
std::optional<End> find_end(const Trial& trial, double t_end_s) {
  std::optional<End> end;
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

Wide sign_between(const std::vector<Wide>& a, const std::vector<Wide>& b, std::size_t at) {
  Wide along = 0;
  for (std::size_t k = at; k < at + 4; ++k) along += a[k] * b[k];
  return along < 0 ? -1 : 1;
}

// The largest value of each kind over the run. Kinds of one unit share theirs, and forces with torques, speeds with turning
// rates by way of the mechanism's size: a torque that is zero but for round-off has the scale of the forces' moments.
std::vector<Wide> scales(const Scene& scene, const MechanismPath& path) {
  std::vector<Wide> made(kinds, Wide(0));
  for (const Sample& sample : path.samples)
    each_value(scene, sample, [&](const Wide& x, ValueKind kind) { made[kind] = std::max(made[kind], magnitude(x)); });
  Wide size = 0;
  for (const Joint& joint : scene.joints)
    for (const auto& anchor : joint.anchors_body_m)
      for (const double x : anchor) size = std::max(size, magnitude(Wide(x)));
  if (size == 0) size = made[position];
  if (size == 0) size = 1;
  const auto share = [&](std::initializer_list<std::pair<ValueKind, bool>> group) {  // true: times a length
    Wide largest = 0;
    for (const auto& [kind, long_unit] : group) largest = std::max(largest, long_unit ? made[kind] / size : made[kind]);
    for (const auto& [kind, long_unit] : group) made[kind] = long_unit ? largest * size : largest;
  };
  made[position] = std::max(made[position], size);
  made[coordinate_length] = made[position];
  made[coordinate_angle] = std::max(made[coordinate_angle], Wide(1));
  share({{velocity, true}, {rate_speed, true}, {turning, false}, {rate_turning, false}});
  share({{force, false}, {tension, false}, {torque, true}, {applied, true}});
  for (Wide& s : made)
    if (s == 0) s = 1;
  return made;
}

// The largest distance of each number from those of the others; infinite when one is not a number. Quaternions of either
// sign are the same attitude.
std::vector<Wide> differences(const Scene& scene, const Sample& sample, std::initializer_list<const Sample*> others) {
  const std::vector<Wide> value = values_of(scene, sample);
  std::vector<Wide> made(value.size(), Wide(0));
  for (const Sample* other : others) {
    const std::vector<Wide> theirs = values_of(scene, *other);
    std::size_t i = 0, in_quaternion = 0;
    Wide sign = 1;
    each_value(scene, sample, [&](const Wide&, ValueKind kind) {
      if (kind == attitude && in_quaternion++ % 4 == 0) sign = sign_between(value, theirs, i);
      const Wide apart = magnitude(value[i] - (kind == attitude ? sign : Wide(1)) * theirs[i]);
      if (!(apart <= made[i])) made[i] = apart == apart ? apart : Wide(HUGE_VAL);
      ++i;
    });
  }
  return made;
}

Bars compare(const Scenario& scenario, std::int64_t samples, const Trial& trial) {
  const Scene& scene = scenario.scene;
  Bars made;
  made.end = find_end(trial, scenario.t_end_s);
  const std::vector<Wide> scale = scales(scene, trial.tight);
  const std::size_t count =
      std::min({trial.tight.samples.size(), trial.loose.samples.size(), trial.maximal.samples.size()});
  made.bounded = made.certified = count;
  std::vector<Wide> farthest(kinds, Wide(0));  // of each kind, so far
  for (std::size_t k = 0; k < count; ++k) {
    const Wide t = Wide(scenario.t_end_s) * Wide(static_cast<double>(k)) / Wide(static_cast<double>(samples));
    if (made.certified == count && made.end && k > 0 && t >= made.end->t_s * (1 - Wide(kEndMargin))) made.certified = k;
    Sample marked = trial.tight.samples[k];
    for (std::size_t j = 0; j < marked.joints.size(); ++j)
      marked.joints[j].not_unique = trial.maximal.samples[k].joints[j].not_unique;
    const std::vector<char> open = open_values(scene, marked);
    const std::vector<Wide> apart =
        differences(scene, trial.tight.samples[k], {&trial.loose.samples[k], &trial.maximal.samples[k]});
    std::size_t i = 0;
    each_value(scene, marked, [&](const Wide&, ValueKind kind) {
      if (!open[i]) farthest[kind] = std::max(farthest[kind], apart[i]);
      ++i;
    });
    i = 0;
    each_value(scene, marked, [&](Wide& bar, ValueKind kind) {
      const Wide least = trial.two_runs ? Wide(kShareOfLargest) * farthest[kind] : Wide(0);
      bar = open[i] ? Wide(0) : kBarSafety * std::max(apart[i], least) + Wide(kQuadRoundOff) * scale[kind];
      if (!open[i] && k < made.certified) {
        made.largest = std::max(made.largest, static_cast<double>(bar / scale[kind]));
        if (!(bar <= Wide(kUselessBar) * scale[kind])) made.bounded = std::min(made.bounded, k);
      }
      ++i;
    });
    marked.t_s = t;
    made.samples.push_back(std::move(marked));
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
                           double rest_span, Arithmetic arithmetic) {
  const Scene& scene = scenario.scene;
  const auto motion = reduced_motion(scene, scenario.t_end_s, start, arithmetic);
  return integrate_mechanism(*motion, start,
                             {scene, scenario.t_end_s, samples, tolerance, rest_span * scenario.t_end_s});
}

MechanismPath maximal_path(const Scenario& scenario, std::int64_t samples, const Sample& start, double tolerance) {
  const Scene& scene = scenario.scene;
  const auto motion = maximal_motion(scene, scenario.t_end_s, start);
  return integrate_mechanism(*motion, start, {scene, scenario.t_end_s, samples, tolerance, 1e-12 * scenario.t_end_s});
}

Trial attempt(const Scenario& scenario, std::int64_t samples, const Sample& start, double tolerance, bool with_loose) {
  Trial made;
  made.tight = reduced_path(scenario, samples, start, tolerance, 1e-12, Arithmetic::quad);
  made.loose =
      with_loose ? reduced_path(scenario, samples, start, 1e3 * tolerance, 1e-11, Arithmetic::quad) : made.tight;
  made.maximal = maximal_path(scenario, samples, start, tolerance);
  made.two_runs = !with_loose;
  return made;
}

// The motion in maximal coordinates, in quad, and that of the spanning tree, in long double.
Trial attempt_large(const Scenario& scenario, std::int64_t samples, const Sample& start, bool very_many) {
  Trial made;
  made.maximal = made.tight = maximal_path(scenario, samples, start, kMaximalTolerance);
  made.loose = reduced_path(scenario, samples, start, very_many ? kVeryManyRatesTolerance : kLongDoubleTolerance, 1e-12,
                            Arithmetic::long_double);
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

Truth refused(const std::string& reason) {
  Truth made;
  made.source = "extended";
  made.outcome.status = Status::unsupported;
  made.outcome.reason = reason;
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
  for (std::size_t k = 0; k < trial.tight.events.size(); ++k) {
    if (bars.end && trial.tight.events[k].t_s >= bars.end->t_s * (1 - Wide(kEndMargin))) break;
    truth.events.push_back(trial.tight.events[k]);
    truth.event_bar_s.push_back(bars.events_s[k]);
  }
  if (bars.end) {
    truth.outcome.status = Status::unsupported;
    truth.outcome.reason = bars.end->why;
  }
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
      if (!why.empty()) return refused(why);
    if (samples < 1 || !(scenario.t_end_s > 0))
      return refused("expected t_end_s > 0 and at least 1 sample; found t_end_s = " + format_double(scenario.t_end_s) +
                     " and " + std::to_string(samples) + " samples");
    return solve(scenario, samples);
  } catch (const MechanismError& error) {
    return refused(error.what());
  }
}

}  // namespace atwood
