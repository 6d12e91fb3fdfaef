// Agreement of contacts: times and places of impacts, impulses, transitions, and heights of apexes.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "dynamics/contacts.hpp"
#include "dynamics/invariants.hpp"
#include "validation/metrics/bisection.hpp"
#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood::metrics {
namespace {

constexpr double kClearance_m = 1e-3;  // impacts and apexes below it belong to the end of a bounce series
constexpr int kApexes = 5;

using Pair = std::pair<int, int>;

// Impacts at the stop of a joint count down to this rate before the impact [rad/s or m/s].
constexpr double kStopRate = 1e-3;

bool fixed_pair(const Scene& scene, const Event& e) {
  return scene.bodies[e.body_a].fixed || scene.bodies[e.body_b].fixed;
}

// Whether the clearance before the impact, vn^2 / 2 g_n with the component of gravity along the normal, was at least
// kClearance_m. Two free bodies have the same acceleration, so their impacts always count.
bool fell_far_enough(const Scene& scene, const Event& e) {
  if (stop_of(scene, e) != nullptr) return e.vn_before_m_per_s * e.vn_before_m_per_s >= kStopRate * kStopRate;
  if (!fixed_pair(scene, e)) return true;
  Wide along = 0;
  for (int i = 0; i < 3; ++i) along += e.normal[i] * scene.gravity_m_per_s2[i];
  if (along < 0) along = -along;
  return e.vn_before_m_per_s * e.vn_before_m_per_s >= 2 * along * Wide(kClearance_m);
}

struct Impact {
  Event event;
  double bar_s = 0;
};
std::map<Pair, std::vector<Impact>> impacts(const std::vector<Event>& events, const std::vector<double>& bars) {
  std::map<Pair, std::vector<Impact>> by_pair;
  for (std::size_t i = 0; i < events.size(); ++i)
    if (events[i].kind == EventKind::impact)
      by_pair[{events[i].body_a, events[i].body_b}].push_back({events[i], i < bars.size() ? bars[i] : 0});
  return by_pair;
}

// Compares impact k of a pair in the run with impact k of that pair in the truth. A missing impact makes the figures
// NaN, and a gate on them fails: a maximum over the reported impacts would hide the missing one.
double magnitude(Wide x) { return std::fabs(static_cast<double>(x)); }

void append_impacts(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows) {
  const auto expected = impacts(truth.events, truth.event_bar_s);
  auto reported = impacts(run.events, {});
  if (expected.empty() || (reported.empty() && run.events.empty())) return;
  Largest time, place, normal, tangential;
  std::int64_t wanted = 0, found = 0, extra = 0;
  for (const auto& [pair, list] : expected) {
    const auto& mine = reported[pair];
    std::size_t k = 0;
    for (; k < list.size() && fell_far_enough(scenario.scene, list[k].event); ++k) {
      ++wanted;
      if (k >= mine.size()) continue;
      ++found;
      const Event &is = mine[k].event, &should = list[k].event;
      const double bar_s = list[k].bar_s, speed = magnitude(should.vn_before_m_per_s);
      time.take(magnitude(is.t_s - should.t_s), bar_s);
      place.take(distance(is.x_m, should.x_m), bar_s * speed);
      normal.take(magnitude(is.impulse_n_N_s - should.impulse_n_N_s), 0);
      tangential.take(magnitude(is.impulse_t_N_s - should.impulse_t_N_s), 0);
    }
    for (; k < mine.size(); ++k) extra += k >= list.size() && fell_far_enough(scenario.scene, mine[k].event);
  }
  for (const auto& [pair, mine] : reported)
    if (!expected.contains(pair)) extra += static_cast<std::int64_t>(mine.size());
  if (wanted == 0) return;
  const std::string count = std::to_string(found) + " of " + std::to_string(wanted) + " impacts";
  const auto add = [&](const char* metric, const Largest& worst) {
    rows.push_back(row(metric, found < wanted ? std::nan("") : worst.value(), worst.bar(),
                       found < wanted ? count + " reported" : ""));
  };
  add("impact-time-error", time);
  add("impact-place-error", place);
  add("impact-normal-impulse-error", normal);
  add("impact-tangential-impulse-error", tangential);
  rows.push_back(row("impact-count-error", static_cast<double>(found + extra - wanted), 0, count));
}

// Rest, slip, stick, roll, separate: compares the k-th of a kind and pair with the truth's k-th. An engine that reports
// none of these kinds has no row; one that reports some and misses one has NaN.
void append_transitions(const Truth& truth, const Recording& run, std::vector<Row>& rows) {
  using Key = std::pair<Pair, EventKind>;
  const auto sorted = [](const std::vector<Event>& events, const std::vector<double>& bars) {
    std::map<Key, std::vector<std::pair<Wide, double>>> by_key;
    for (std::size_t i = 0; i < events.size(); ++i)
      if (events[i].kind != EventKind::impact)
        by_key[{{events[i].body_a, events[i].body_b}, events[i].kind}].push_back(
            {events[i].t_s, i < bars.size() ? bars[i] : 0});
    return by_key;
  };
  const auto expected = sorted(truth.events, truth.event_bar_s);
  const auto reported = sorted(run.events, {});
  if (expected.empty() || reported.empty()) return;
  Largest worst;
  std::string missing;
  for (const auto& [key, list] : expected) {
    const auto mine = reported.find(key);
    for (std::size_t k = 0; k < list.size(); ++k) {
      if (mine != reported.end() && k < mine->second.size())
        worst.take(magnitude(mine->second[k].first - list[k].first), list[k].second);
      else if (missing.empty()) missing = "no `" + to_string(key.second) + "` reported where the truth has one";
    }
  }
  rows.push_back(row("transition-time-error", missing.empty() ? worst.value() : std::nan(""), worst.bar(), missing));
}

void append_restitution(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  double worst = -1, gain = 0;
  bool any = false;
  for (const Event& e : run.events) {
    if (e.kind != EventKind::impact || !(e.vn_before_m_per_s < 0)) continue;
    const double work = static_cast<double>(e.impulse_n_N_s * (e.vn_before_m_per_s + e.vn_after_m_per_s) / 2);
    gain = any ? std::max(gain, work) : work;
    any = true;
    if (!fell_far_enough(scenario.scene, e)) continue;
    const Joint* stop = stop_of(scenario.scene, e);
    const double asked =
        stop != nullptr ? stop->limits->restitution : pair_law(scenario.scene, e.body_a, e.body_b).restitution;
    worst = std::max(worst, std::fabs(static_cast<double>(-e.vn_after_m_per_s / e.vn_before_m_per_s - asked)));
  }
  if (worst >= 0) rows.push_back(row("restitution-error", worst));
  if (any) rows.push_back(row("contact-energy-gain", gain));
}

// From the states, so that work of friction and of corrections by the engine is included. Where gravity is the only
// force, energy changes between samples by contacts only.
void append_energy_gain(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows) {
  if (!scenario.scene.forces.empty() || !scenario.scene.joint_forces.empty() || run.values.size() < 2) return;
  Wide least = 0, gain = 0;
  for (std::size_t k = 0; k < run.values.size(); ++k) {
    const dynamics::Energy e = dynamics::energy(scenario.scene, run.values[k]);
    const Wide total = e.kinetic_J + e.potential_J;
    if (k == 0) least = total;
    gain = std::max(gain, Wide(total - least));
    least = std::min(least, total);
  }
  const EnergyScale scale = energy_scale(scenario, truth);
  if (scale.joules > 0) rows.push_back(row("energy-gain", static_cast<double>(gain / scale.joules)));
  else rows.push_back(row("energy-rise", static_cast<double>(gain), 0, "in joules: no truth's energy to scale by"));
}

dynamics::Gap<Wide> gap_at(const Scene& scene, const dynamics::Layout& layout, const dynamics::ContactPair& pair,
                           const SampleView& sample) {
  const std::vector<Wide> y = dynamics::pack<Wide>(scene, sample);
  return dynamics::gap(scene, layout, pair, y.data());
}

// Height of the vertex of the parabola through three equally spaced values.
Wide vertex(Wide a, Wide b, Wide c) {
  const Wide curvature = a - 2 * b + c, rise = c - a;
  return curvature < 0 ? b - rise * rise / (8 * curvature) : std::max({a, b, c});
}

// The flights of a pair after its impacts: from one to the next, at least three samples strictly inside, true apex at
// least kClearance_m. The three samples are the middle ones; the run's apex is taken from the same three.
void append_apexes(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows) {
  const Scene& scene = scenario.scene;
  const dynamics::Layout layout = dynamics::layout(scene);
  const auto expected = impacts(truth.events, {});
  Largest worst;
  int apexes = 0;
  for (const auto& [bodies, list] : expected) {
    const dynamics::ContactPair pair{bodies.first, bodies.second, 0, 0};
    if (stop_of(scene, list.front().event) != nullptr || !fixed_pair(scene, list.front().event) ||
        !dynamics::has_gap(scene, pair))
      continue;
    for (std::size_t k = 0; k + 1 < list.size() && k < kApexes; ++k) {
      std::vector<std::size_t> inside;
      for (std::size_t s = 0; s < truth.values.size(); ++s)
        if (truth.values[s].t_s > list[k].event.t_s && truth.values[s].t_s < list[k + 1].event.t_s) inside.push_back(s);
      if (inside.size() < 3) continue;
      const std::size_t m = inside[inside.size() / 2];
      const auto apex = [&](const SampleSeries& values) {
        return vertex(gap_at(scene, layout, pair, values[m - 1]).gap_m, gap_at(scene, layout, pair, values[m]).gap_m,
                      gap_at(scene, layout, pair, values[m + 1]).gap_m);
      };
      const Wide right = apex(truth.values);
      if (right < Wide(kClearance_m)) continue;
      ++apexes;
      const double off = std::fabs(static_cast<double>((apex(run.values) - right) / right));
      double b = 0;  // the bars of the three samples, by their weights at the vertex
      if (m < truth.bars.size())
        b = (norm(truth.bars[m].bodies[pair.a].p_m) + norm(truth.bars[m].bodies[pair.b].p_m)) /
            static_cast<double>(right);
      worst.take(off, b);
    }
  }
  if (apexes > 0) rows.push_back(row("apex-error", worst.value(), worst.bar(), std::to_string(apexes) + " apexes"));
}

// Where a falling body crosses z = 0: x, y by the parabola through three samples (one before the crossing's interval,
// and its two ends; at the start of a run the one after instead), where the parabola of z is 0.
std::optional<std::array<Wide, 2>> landing(const SampleSeries& values, int body) {
  for (std::size_t k = 1; k + 1 < values.size(); ++k) {
    const auto z = [&](std::size_t i) { return values[i].bodies[body].p_m[2]; };
    if (!(z(k) > 0 && z(k + 1) <= 0)) continue;
    // Newton's form over s = 0, 1, 2 at samples k - 1, k, k + 1; the zero lies in (1, 2].
    const auto at = [&](int axis, Wide s) {
      const Wide a = values[k - 1].bodies[body].p_m[axis], b = values[k].bodies[body].p_m[axis],
                 c = values[k + 1].bodies[body].p_m[axis];
      return a + s * (b - a) + s * (s - 1) / 2 * (c - 2 * b + a);
    };
    const auto landed = bisect([&](Wide s) { return at(2, s); }, Wide(1), Wide(2), 113);
    if (!landed.converged) return std::nullopt;
    return std::array<Wide, 2>{at(0, landed.high), at(1, landed.high)};
  }
  return std::nullopt;
}

}  // namespace

void append_landing(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows) {
  const bool asked = scenario.id.starts_with("ballistic") || std::ranges::count(scenario.tags, "landing") > 0;
  if (!asked) return;
  for (std::size_t b = 0; b < scenario.scene.bodies.size(); ++b) {
    if (scenario.scene.bodies[b].fixed) continue;
    const auto right = landing(truth.values, static_cast<int>(b));
    if (!right) continue;
    const auto mine = landing(run.values, static_cast<int>(b));
    const auto& start = truth.values.front().bodies[b].p_m;
    const auto range = [&](const std::array<Wide, 2>& p) { return norm({p[0] - start[0], p[1] - start[1], 0}); };
    double bar = 0;
    for (const SampleView s : truth.bars) bar = std::max(bar, norm(s.bodies[b].p_m));
    rows.push_back(row("landing-range-error", mine ? range(*mine) - range(*right) : std::nan(""), bar,
                       mine ? "" : "the run does not land"));
    return;
  }
}

void append_contact(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows) {
  const bool touches = dynamics::contacts_possible(scenario.scene);
  const bool stops = std::ranges::any_of(scenario.scene.joints, [](const Joint& j) { return j.limits.has_value(); });
  if (!touches && !stops) return;
  if (has_truth(truth)) {
    append_impacts(scenario, truth, run, rows);
    append_transitions(truth, run, rows);
    append_apexes(scenario, truth, run, rows);
  }
  append_restitution(scenario, run, rows);
  append_energy_gain(scenario, truth, run, rows);
  if (!touches) return;
  append_contact_forces(scenario, run, rows);
  append_penetration(scenario.scene, run, rows);
}

}  // namespace atwood::metrics
