#include "extended/extended.hpp"

#include <algorithm>
#include <cstdio>

#include "dynamics/arithmetic.hpp"
#include "dynamics/rates.hpp"
#include "extended/collocation.hpp"
#include "extended/extrapolation.hpp"
#include "extended/path.hpp"

namespace atwood {

namespace {

using namespace extended;
using dynamics::Layout;
using dynamics::magnitude;

constexpr double target_bar = 1e-20;  // of the scale
constexpr double unbounded = 1e-3;     // a bar this wide bounds nothing
// When one of the methods is right the largest difference is the other's whole error, and no more: twice that is the
// bar.
constexpr double bar_safety = 2;
constexpr double quad_round_off = 1e-33;

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
    return std::make_unique<Collocation>(
        Problem{layout.size, groups_of(layout), std::move(rate), std::move(narrow)}, tolerance);
  };
}

struct Trial { Path<Wide> close, wide, gauss; };

// The largest value of each component's kind over the run; 1 where the kind never leaves zero.
std::vector<Wide> scales(const Layout& layout, const Path<Wide>& path) {
  Scale<Wide> largest(layout.size, groups_of(layout));
  for (const auto& state : path.states) largest.see(state.data());
  std::vector<Wide> made;
  for (int i = 0; i < layout.size; ++i) made.push_back(largest.of(i));
  return made;
}

// largest: relative to the scale; bounded: the samples before the first bar that bounds nothing.
struct Bars { std::vector<std::vector<Wide>> values; double largest = 0; std::size_t bounded = 0; };

Bars compare(const Layout& layout, const Trial& trial) {
  Bars made;
  const std::vector<Wide> scale = scales(layout, trial.close);
  made.bounded = trial.close.states.size();
  made.values.assign(trial.close.states.size(), std::vector<Wide>(layout.size, Wide(0)));
  for (std::size_t k = 1; k < made.values.size(); ++k)
    for (int i = 0; i < layout.size; ++i) {
      const Wide value = trial.close.states[k][i];
      const Wide apart =
          std::max(magnitude(value - trial.wide.states[k][i]), magnitude(value - trial.gauss.states[k][i]));
      const Wide bar = bar_safety * apart + Wide(quad_round_off) * scale[i];
      made.values[k][i] = bar;
      made.largest = std::max(made.largest, static_cast<double>(bar / scale[i]));
      if (!(bar <= Wide(unbounded) * scale[i])) made.bounded = std::min(made.bounded, k);
    }
  return made;
}

Trial attempt(const Scene& scene, double t_end_s, std::int64_t samples, const Layout& layout, double tolerance) {
  const std::vector<Wide> initial = dynamics::pack<Wide>(scene);
  Trial made;
  made.close = walk<Wide>(scene, t_end_s, samples, initial, extrapolation(layout, tolerance));
  if (!made.close.failure.empty()) return made;
  made.wide = walk<Wide>(scene, t_end_s, samples, initial, extrapolation(layout, 1e3 * tolerance));
  made.gauss = walk<Wide>(scene, t_end_s, samples, initial, collocation(layout, tolerance));
  for (const Path<Wide>* path : {&made.wide, &made.gauss})
    if (!path->failure.empty()) made.close.failure = path->failure;
  const auto impacts = made.close.events.size();
  if (made.close.failure.empty() && (made.wide.events.size() != impacts || made.gauss.events.size() != impacts))
    made.close.failure = "the two methods disagree on the number of impacts";
  return made;
}

void fill_events(Truth& truth, const Trial& trial) {
  truth.events = trial.close.events;
  for (std::size_t k = 0; k < truth.events.size(); ++k) {
    const Wide t = truth.events[k].t_s;
    const Wide apart = std::max(magnitude(t - trial.wide.events[k].t_s), magnitude(t - trial.gauss.events[k].t_s));
    const Wide bar = bar_safety * apart + Wide(quad_round_off) * t;
    truth.event_bar_s.push_back(static_cast<double>(bar));
  }
}

// The rates of lorenz stand for its velocity: their bars follow from those of the unknowns.
void lorenz_bars(Sample& bar, const Sample& value) {
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
  if (const std::string why = dynamics::unsupported(scene); !why.empty()) return refused(why, Status::unsupported);
  if (samples < 1 || !(scenario.t_end_s > 0)) return refused("no samples to solve for", Status::unsupported);
  const Layout layout = dynamics::layout(scene);
  Truth truth;
  truth.source = "extended: GBS 24 and Gauss 20 in quad";
  double tolerance = 1e-28;
  Trial trial = attempt(scene, scenario.t_end_s, samples, layout, tolerance);
  if (!trial.close.failure.empty())
    return refused(trial.close.failure,
                   trial.close.failure.find("singular") != std::string::npos ? Status::diverged : Status::unsupported);
  Bars bars = compare(layout, trial);
  truth.condition = flow_condition(scene, scenario.t_end_s, samples);
  if (bars.largest > target_bar) {  // closer
    Trial closer = attempt(scene, scenario.t_end_s, samples, layout, 1e-31);
    Bars narrower = closer.close.failure.empty() ? compare(layout, closer) : bars;
    if (narrower.largest < bars.largest) {
      trial = std::move(closer);
      bars = std::move(narrower);
    }
  }
  if (bars.largest > target_bar) truth.note = note_on(bars, truth.condition, scenario.t_end_s, samples);
  for (std::size_t k = 0; k < trial.close.states.size(); ++k) {
    const Wide t = Wide(scenario.t_end_s) * Wide(static_cast<double>(k)) / Wide(static_cast<double>(samples));
    truth.values.push_back(dynamics::unpack<Wide>(scene, t, trial.close.states[k].data()));
    truth.bars.push_back(dynamics::unpack_bars<Wide>(scene, t, bars.values[k].data()));
    if (!scene.problem.empty()) lorenz_bars(truth.bars.back(), truth.values.back());
  }
  fill_events(truth, trial);
  truth.outcome.steps_taken = trial.close.steps;
  truth.outcome.rate_evaluations = trial.close.evaluations + trial.wide.evaluations + trial.gauss.evaluations;
  return truth;
}

}  // namespace atwood
