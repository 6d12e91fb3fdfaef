#include "extended/extended.hpp"

#include <algorithm>
#include <cstdio>

#include "dynamics/arithmetic.hpp"
#include "dynamics/contacts.hpp"
#include "dynamics/error_growth.hpp"
#include "dynamics/rates.hpp"
#include "dynamics/shared_errors.hpp"
#include "extended/bars.hpp"
#include "extended/collocation.hpp"
#include "extended/extrapolation.hpp"
#include "extended/mechanism_truth.hpp"
#include "extended/path.hpp"

namespace atwood {

namespace {

using namespace extended;
using dynamics::at_time;
using dynamics::CertifiedEnd;
using dynamics::end_at;
using dynamics::Layout;
using dynamics::magnitude;

constexpr double kQuadRoundOff = 1e-33;
constexpr double kQuadUnit = 0x1p-113;

std::vector<int> groups_of(const Layout& layout) {
  std::vector<int> groups;
  for (const dynamics::Kind kind : layout.kinds) groups.push_back(static_cast<int>(kind));
  return groups;
}

MakeStepper<Wide> extrapolation(const Layout& layout, double tolerance) {
  return [&layout, tolerance](Rate<Wide> rate, Rate<double>) {
    return std::make_unique<Extrapolation<Wide>>(layout.size, groups_of(layout), std::move(rate), tolerance);
  };
}

MakeStepper<Wide> collocation(const Layout& layout, double tolerance) {
  return [&layout, tolerance](Rate<Wide> rate, Rate<double> narrow) {
    return std::make_unique<Collocation>(Problem{layout.size, groups_of(layout), std::move(rate), std::move(narrow)},
                                         tolerance);
  };
}

// Three runs at one tolerance. end: end of the certified part; empty: the whole run.
struct Trial {
  Path<Wide> tight, loose, gauss;
  std::int64_t samples = 0;
  std::optional<CertifiedEnd> end;

  void drop_comparisons() { loose.states.clear(), gauss.states.clear(); }  // once they are in the bars
};

// The largest value of each component's kind over the run; 1 for a kind whose values are all zero. Velocities that
// would not move a body by its own distance in 1e9 runs are round-off of something at rest, and no scale.
std::vector<Wide> scales(const Layout& layout, const Path<Wide>& path, double t_end_s) {
  Scale<Wide> largest(layout.size, groups_of(layout));
  for (std::size_t k = 0; k < path.states.size(); ++k) largest.include(path.states[k].data());
  std::vector<Wide> made;
  for (int i = 0; i < layout.size; ++i) made.push_back(largest.of(i));
  Wide farthest = 0;
  for (int i = 0; i < layout.size; ++i)
    if (layout.kinds[i] == dynamics::Kind::position) farthest = std::max(farthest, made[i]);
  for (int i = 0; i < layout.size; ++i) {
    if (layout.kinds[i] == dynamics::Kind::velocity) made[i] = std::max(made[i], farthest / (Wide(1e9) * t_end_s));
    if (layout.kinds[i] == dynamics::Kind::rate) made[i] = std::max(made[i], 1 / (Wide(1e9) * t_end_s));
  }
  return made;
}

// largest: relative to the scale; bounded: number of samples before the bars above kUselessBar that last to the end;
// certified: number of samples before the end.
struct Bars {
  RaggedArray<Wide> values;
  std::vector<double> events_s;
  double largest = 0;
  std::size_t bounded = 0, certified = 0;
  std::optional<CertifiedEnd> end;
};

Bars differences(const Layout& layout, const Trial& trial, double t_end_s) {
  Bars made;
  const std::vector<Wide> scale = scales(layout, trial.tight, t_end_s);
  const std::size_t samples =
      std::min({trial.tight.states.size(), trial.loose.states.size(), trial.gauss.states.size()});
  made.values = RaggedArray<Wide>(samples, static_cast<std::size_t>(layout.size));
  for (std::size_t k = 1; k < samples; ++k)
    for (int i = 0; i < layout.size; ++i) {
      const Wide value = trial.tight.states[k][i];
      const Wide apart =
          std::max(magnitude(value - trial.loose.states[k][i]), magnitude(value - trial.gauss.states[k][i]));
      made.values[k][i] = kBarSafety * apart + Wide(kQuadRoundOff) * scale[i];
    }
  for (std::size_t k = 0; k < trial.tight.events.size(); ++k) {
    const Wide t = trial.tight.events[k].t_s;
    Wide apart = 0;
    for (const Path<Wide>* other : {&trial.loose, &trial.gauss})
      if (k < other->events.size()) apart = std::max(apart, magnitude(t - other->events[k].t_s));
    made.events_s.push_back(static_cast<double>(kBarSafety * apart + Wide(kQuadRoundOff) * t));
  }
  return made;
}

// The differences between the runs plus the errors that they share.
Bars compare(const Scene& scene, double t_end_s, const Layout& layout, const Trial& trial) {
  Bars made = differences(layout, trial, t_end_s);
  made.end = trial.end;
  if (!trial.tight.instants.empty()) {
    const dynamics::SharedErrors shared = dynamics::shared_errors(
        scene, t_end_s, trial.tight.instants, trial.tight.events, made.events_s, made.values, kQuadUnit);
    for (std::size_t k = 0; k < made.values.size(); ++k)
      for (int i = 0; i < layout.size; ++i) made.values[k][i] += shared.samples[k][i];
    for (std::size_t k = 0; k < made.events_s.size(); ++k) made.events_s[k] += shared.events_s[k];
    if (shared.end) end_at(made.end, shared.end->t_s, shared.end->why);
  }
  const std::vector<Wide> scale = scales(layout, trial.tight, t_end_s);
  made.bounded = trial.tight.states.size();
  made.certified = made.values.size();
  for (std::size_t k = 1; k < made.values.size(); ++k) {
    const Wide t = Wide(t_end_s) * Wide(static_cast<double>(k)) / Wide(static_cast<double>(trial.samples));
    if (made.end && !made.end->is_after(t)) {
      made.certified = k;
      break;
    }
    bool bounded = true;
    for (int i = 0; i < layout.size; ++i) {
      const Wide bar = made.values[k][i];
      made.largest = std::max(made.largest, static_cast<double>(bar / scale[i]));
      bounded = bounded && bar <= Wide(kUselessBar) * scale[i];
    }
    if (!bounded) made.bounded = std::min(made.bounded, k);
    else made.bounded = trial.tight.states.size();  // before it, the velocity's jump at an impact
  }
  return made;
}

// The first time at which one run has another impact than the rest, or failed.
void find_end(Trial& trial) {
  for (const Path<Wide>* path : {&trial.tight, &trial.loose, &trial.gauss})
    if (path->valid_until_failure) end_at(trial.end, path->end, path->failure + at_time(path->end));
  const auto& events = trial.tight.events;
  for (const Path<Wide>* other : {&trial.loose, &trial.gauss}) {
    const std::size_t both = std::min(events.size(), other->events.size());
    std::size_t k = 0;
    while (k < both && events[k].kind == other->events[k].kind && events[k].body_a == other->events[k].body_a &&
           events[k].body_b == other->events[k].body_b)
      ++k;
    if (k == events.size() && k == other->events.size()) continue;
    const Wide mine = k < events.size() ? events[k].t_s : trial.tight.end,
               theirs = k < other->events.size() ? other->events[k].t_s : other->end;
    const Wide t_s = std::min(mine, theirs);
    end_at(trial.end, t_s, "the runs disagree on the impact" + at_time(t_s));
  }
}

Trial attempt(const Scene& scene, double t_end_s, std::int64_t samples, const Layout& layout, double tolerance) {
  const std::vector<Wide> initial = dynamics::pack<Wide>(scene);
  Trial made;
  made.samples = samples;
  const auto failed = [&](const Path<Wide>& path) {
    if (path.failure.empty() || path.valid_until_failure) return false;
    made.tight.failure = path.failure;
    made.tight.valid_until_failure = false;
    return true;
  };
  made.tight = integrate_path<Wide>(scene, t_end_s, samples, initial, extrapolation(layout, tolerance));
  if (failed(made.tight)) return made;
  made.loose =
      integrate_path<Wide>(scene, t_end_s, samples, initial, extrapolation(layout, 1e3 * tolerance), Grid::free);
  if (failed(made.loose)) return made;
  made.gauss = integrate_path<Wide>(scene, t_end_s, samples, initial, collocation(layout, tolerance));
  if (failed(made.gauss)) return made;
  find_end(made);
  made.tight.failure.clear();
  return made;
}

// The velocity of `lorenz` is its rate: its bars follow from those of the position, to first order.
void lorenz_bars(const SampleReference& bar, const SampleView& value) {
  const auto& p = value.bodies[0].p_m;
  const auto& d = bar.bodies[0].p_m;
  bar.bodies[0].v_m_per_s = {10 * (d[0] + d[1]), magnitude(28 - p[2]) * d[0] + d[1] + magnitude(p[0]) * d[2],
                             magnitude(p[1]) * d[0] + magnitude(p[0]) * d[1] + Wide(8) / 3 * d[2]};
}

std::string in_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1e", value);
  return text;
}

std::string note_on(const Bars& bars, double condition, double t_end_s, std::int64_t samples) {
  std::string note;
  if (bars.bounded <= static_cast<std::size_t>(samples)) {
    const double last_s = t_end_s * static_cast<double>(bars.bounded - 1) / static_cast<double>(samples);
    note = "not bounded after t = " + format_double(last_s) +
           " s: the methods differ by more than a thousandth of the scale; ";
  }
  return note + "bars up to " + in_digits(bars.largest) + " of the scale: the flow magnifies a perturbation " +
         in_digits(condition) + " times, and quad carries 1e-33";
}

Truth refused(const std::string& reason, Status status) {
  Truth made;
  made.source = "extended";
  made.outcome.status = status;
  made.outcome.reason = reason;
  return made;
}

}  // namespace

Truth extended_truth(const Scenario& scenario, std::int64_t samples) {
  const Scene& scene = scenario.scene;
  if (!scene.joints.empty() || !scene.ropes.empty()) return mechanism_truth(scenario, samples);
  if (const std::string why = dynamics::unsupported(scene); !why.empty()) return refused(why, Status::unsupported);
  if (samples < 1 || !(scenario.t_end_s > 0))
    return refused("expected t_end_s > 0 and at least 1 sample; found t_end_s = " + format_double(scenario.t_end_s) +
                       " and " + std::to_string(samples) + " samples",
                   Status::unsupported);
  const Layout layout = dynamics::layout(scene);
  if (dynamics::contacts_possible(scene) && layout.size > dynamics::ErrorGrowth::kMaxUnknowns)
    return refused("contacts in a scene of " + std::to_string(layout.size) + " unknowns, more than " +
                       std::to_string(dynamics::ErrorGrowth::kMaxUnknowns) + ", are not covered by the extended truth",
                   Status::unsupported);
  Truth truth;
  truth.source = "extended: GBS 24 and Gauss 20 in quad";
  double tolerance = 1e-28;
  Trial trial = attempt(scene, scenario.t_end_s, samples, layout, tolerance);
  if (!trial.tight.failure.empty())
    return refused(trial.tight.failure,
                   trial.tight.failure.find("singular") != std::string::npos ? Status::diverged : Status::unsupported);
  Bars bars = compare(scene, scenario.t_end_s, layout, trial);
  trial.drop_comparisons();
  truth.condition = flow_condition(scene, scenario.t_end_s, samples);
  if (bars.largest > kTargetBar || (bars.end && !trial.tight.valid_until_failure)) {
    Trial closer = attempt(scene, scenario.t_end_s, samples, layout, 1e-31);
    Bars smaller_bars = closer.tight.failure.empty() ? compare(scene, scenario.t_end_s, layout, closer) : bars;
    if (smaller_bars.certified > bars.certified ||
        (smaller_bars.certified == bars.certified && smaller_bars.largest < bars.largest)) {
      closer.drop_comparisons();
      trial = std::move(closer);
      bars = std::move(smaller_bars);
    }
  }
  if (bars.largest > kTargetBar) truth.note = note_on(bars, truth.condition, scenario.t_end_s, samples);
  truth.values.reserve(bars.certified, scene.bodies.size());
  truth.bars.reserve(bars.certified, scene.bodies.size());
  for (std::size_t k = 0; k < bars.certified; ++k) {
    const Wide t = Wide(scenario.t_end_s) * Wide(static_cast<double>(k)) / Wide(static_cast<double>(samples));
    truth.values.push_back(dynamics::unpack<Wide>(scene, t, trial.tight.states[k].data()));
    truth.bars.push_back(dynamics::unpack_bars<Wide>(scene, t, bars.values[k].data()));
    if (!scene.problem.empty()) lorenz_bars(truth.bars.back(), truth.values.back());
  }
  append_certified_events(trial.tight.events, bars.events_s, bars.end, truth);
  truth.outcome.steps_taken = trial.tight.steps;
  truth.outcome.rate_evaluations = trial.tight.evaluations + trial.loose.evaluations + trial.gauss.evaluations;
  return truth;
}

}  // namespace atwood
