#include <quadmath.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "cvode/bars.hpp"
#include "cvode/cvode.hpp"
#include "cvode/mechanism.hpp"
#include "cvode/run.hpp"
#include "dynamics/arithmetic.hpp"
#include "dynamics/error_growth.hpp"
#include "dynamics/rates.hpp"
#include "dynamics/shared_errors.hpp"
#include "protocol/refusal.hpp"

namespace atwood {

namespace {

using cvode::kRelativeFloor, cvode::kSafety;
// Of one operation; error_growth.hpp counts 64 of them per step. CVODE adds only small corrections at each step.
constexpr double kRoundOff = 0x1p-56;

struct Solved {
  std::vector<Event> events;
  Outcome outcome;
  cvode::Record record;
};

// With contacts the runs are compared at this many instants at least, however few samples are asked for.
constexpr std::int64_t kLeastCompared = 64;

// The samples of the runs, made where they are needed: a state in double takes half of a sample's memory. Each run has
// `parts` times as many as are asked for.
struct Samples {
  const Scenario& scenario;
  std::int64_t asked;
  std::int64_t parts;

  std::int64_t count() const { return asked * parts; }
  bool is_asked(std::size_t k) const { return static_cast<std::int64_t>(k) % parts == 0; }
  Wide t_s(std::size_t k) const {
    const auto n = static_cast<std::int64_t>(k);
    return is_asked(k) ? Wide(scenario.t_end_s) * (n / parts) / asked : Wide(scenario.t_end_s) * n / count();
  }
  Sample of(const Solved& run, std::size_t k) const {
    Sample made = dynamics::unpack<double>(scenario.scene, 0, run.record.states[k].data());
    made.t_s = t_s(k);
    return made;
  }
};

// Sizes of the scene's values at the start. Where all values of a kind are zero, an estimate from the rates and the
// duration of the run.
cvode::Scales scales_of(const Scenario& scenario) {
  const dynamics::Layout layout = dynamics::layout(scenario.scene);
  const dynamics::Dynamics<double> equations(scenario.scene, scenario.t_end_s);
  const std::vector<double> y = dynamics::pack<double>(scenario.scene);
  std::vector<double> f(y.size());
  equations.rate(0, y.data(), f.data(), 0);
  double p = 0, v = 0, a = 0, w = 0, turning = 0;
  for (std::size_t i = 0; i < y.size(); ++i) switch (layout.kinds[i]) {
      case dynamics::Kind::position: p = std::max(p, std::fabs(y[i])); break;
      case dynamics::Kind::velocity: v = std::max(v, std::fabs(y[i])), a = std::max(a, std::fabs(f[i])); break;
      case dynamics::Kind::rate: w = std::max(w, std::fabs(y[i])), turning = std::max(turning, std::fabs(f[i])); break;
      case dynamics::Kind::attitude: break;
    }
  for (const Body& body : scenario.scene.bodies)
    if (const auto* sphere = std::get_if<Sphere>(&body.shape); sphere != nullptr && !body.fixed)
      p = std::max(p, sphere->radius_m);
  const double t = scenario.t_end_s;
  cvode::Scales made;
  if (v == 0) v = a > 0 && p > 0 ? std::fmin(a * t, std::sqrt(a * p)) : a * t;
  if (p == 0) p = v * t;
  if (w == 0) w = turning * t;
  if (p > 0) made.position_m = p;
  if (v > 0) made.velocity_m_per_s = v;
  else made.velocity_m_per_s = made.position_m / t;
  if (w > 0) made.rate_rad_per_s = w;
  return made;
}

Solved solve(const Scenario& scenario, std::int64_t samples, cvode::Family family, double rtol,
             const cvode::Scales& scales) {
  cvode::Options options;
  options.scales = scales;
  options.limit_per_segment = true;  // however many impacts there are
  options.family = family;
  options.rtol = rtol;
  options.atol = rtol / 100;
  options.max_order = family == cvode::Family::adams ? 12 : 5;
  Solved made;
  made.record.states.reserve(static_cast<std::size_t>(samples) + 1,
                             static_cast<std::size_t>(dynamics::layout(scenario.scene).size));
  made.outcome = cvode::run(scenario.scene, scenario.t_end_s, samples, options,
                            {{}, [&](const Event& e) { made.events.push_back(e); }}, &made.record);
  if (made.outcome.status != Status::ok)
    made.outcome.reason += std::string(" (") + (family == cvode::Family::adams ? "Adams" : "BDF") + " at rtol " +
                           format_double(rtol) + ")";
  return made;
}

// Largest difference of an event's time to the closest event of the same kind and pair in each run.
Wide event_time_difference(const Event& event, const std::vector<Solved>& runs) {
  Wide worst = 0;
  for (const Solved& run : runs) {
    Wide nearest = -1;
    for (const Event& other : run.events)
      if (other.kind == event.kind && other.body_a == event.body_a && other.body_b == event.body_b) {
        const Wide apart = fabsq(other.t_s - event.t_s);
        if (nearest < 0 || apart < nearest) nearest = apart;
      }
    worst = fmaxq(worst, nearest < 0 ? fabsq(event.t_s) : nearest);
  }
  return worst;
}

struct Spread {  // of the runs, for one kind of value of one body
  Wide difference = 0, scale = 0;
  // The bar follows from the largest difference up to now, because errors cross zero. Around an impact the runs differ
  // by the velocity jump while they disagree on its time; that difference belongs to this sample alone.
  template <std::size_t N> Wide bar(const std::vector<const std::array<Wide, N>*>& all, bool at_impact) {
    Wide now = 0;
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t a = 0; a < all.size(); ++a)
        for (std::size_t b = 0; b < a; ++b) now = fmaxq(now, fabsq((*all[a])[i] - (*all[b])[i]));
      scale = fmaxq(scale, fabsq((*all[0])[i]));
    }
    if (!at_impact) difference = fmaxq(difference, now);
    return kSafety * fmaxq(difference, now) + kRelativeFloor * scale;
  }
};

// The first time at which the runs have different impacts of a pair, or at which one of them failed. The low bounces
// that a run sums as a series depend on its tolerance and are not a difference.
std::optional<dynamics::CertifiedEnd> first_difference(const Scene& scene, const std::vector<Solved>& runs) {
  std::optional<dynamics::CertifiedEnd> end;
  const auto end_at = [&](Wide t_s, const std::string& why) { dynamics::end_at(end, t_s, why); };
  struct PairEvents {
    std::vector<Wide> t_s;
    bool rests = false;
  };
  std::vector<std::map<std::pair<int, int>, PairEvents>> all;
  for (const Solved& run : runs) {
    if (run.record.valid_until_failure)
      end_at(run.record.end_s, run.outcome.reason + dynamics::at_time(run.record.end_s));
    auto& of = all.emplace_back();
    for (const Event& event : run.events) {
      PairEvents& rigid_contacts = of[{event.body_a, event.body_b}];
      if (event.kind == EventKind::impact) rigid_contacts.t_s.push_back(event.t_s);
      if (event.kind == EventKind::rest) rigid_contacts.rests = true;
    }
  }
  for (auto& run : all)
    for (const auto& [pair, mine] : run)
      for (auto& other : all) {
        const PairEvents& theirs = other[pair];
        if (mine.t_s.size() <= theirs.t_s.size() || (mine.rests && theirs.rests)) continue;
        const Wide t_s = mine.t_s[theirs.t_s.size()];
        end_at(t_s, "CVODE: the runs disagree on the impact of `" + scene.bodies[pair.first].name + "` and `" +
                        scene.bodies[pair.second].name + "`" + dynamics::at_time(t_s));
      }
  return end;
}

// Twice the largest difference between the runs, per sample and component of y.
RaggedArray<Wide> differences(const Samples& samples, const std::vector<Solved>& runs, std::size_t count) {
  const Scene& scene = samples.scenario.scene;
  const dynamics::Layout layout = dynamics::layout(scene);
  RaggedArray<Wide> made(count, static_cast<std::size_t>(layout.size));
  for (std::size_t k = 0; k < count; ++k) {
    std::vector<std::vector<Wide>> states;
    for (const Solved& run : runs) states.push_back(dynamics::pack<Wide>(scene, samples.of(run, k)));
    const std::span<Wide> apart = made[k];
    for (int i = 0; i < layout.size; ++i)
      for (const auto& one : states)
        for (const auto& other : states) apart[i] = fmaxq(apart[i], kSafety * fabsq(one[i] - other[i]));
  }
  return made;
}

// Is this time within the bar of an impact of the body, so that its velocity may be that before or after the impact?
bool impact_within_bar(const Truth& truth, int body, Wide t_s) {
  for (std::size_t e = 0; e < truth.events.size(); ++e) {
    const Event& event = truth.events[e];
    if (event.body_a != body && event.body_b != body) continue;
    if (fabsq(event.t_s - t_s) <= truth.event_bar_s[e] && event.vn_after_m_per_s != event.vn_before_m_per_s)
      return true;
  }
  return false;
}

// The first `count` samples with their bars. `shared`: half-widths of errors that the runs share, or empty.
void add_samples(const Samples& samples, std::size_t count, Truth& truth, const std::vector<Solved>& runs,
                 const std::vector<std::vector<Wide>>& shared) {
  const Scene& scene = samples.scenario.scene;
  struct BodySpread {
    Spread p, q, v, w;
  };
  std::vector<BodySpread> spreads(scene.bodies.size());
  for (std::size_t k = 0; k < count; ++k) {
    Sample bar;
    bar.t_s = samples.t_s(k);
    std::vector<Sample> of_runs;
    for (const Solved& run : runs) of_runs.push_back(samples.of(run, k));
    if (samples.is_asked(k)) truth.values.push_back(of_runs.front());
    const Sample more = shared.empty() ? Sample{} : dynamics::unpack_bars<Wide>(scene, bar.t_s, shared[k].data());
    for (std::size_t i = 0; i < spreads.size(); ++i) {
      BodySample& made = bar.bodies.emplace_back();
      made.q_wxyz = {};
      if (k == 0) continue;
      std::vector<const std::array<Wide, 3>*> p, v, w;
      std::vector<const std::array<Wide, 4>*> q;
      for (const Sample& sample : of_runs) {
        const BodySample& body = sample.bodies[i];
        p.push_back(&body.p_m);
        q.push_back(&body.q_wxyz);
        v.push_back(&body.v_m_per_s);
        w.push_back(&body.w_rad_per_s);
      }
      const bool jump = impact_within_bar(truth, static_cast<int>(i), bar.t_s);
      made.p_m.fill(spreads[i].p.bar(p, false));
      made.q_wxyz.fill(spreads[i].q.bar(q, false));
      made.v_m_per_s.fill(spreads[i].v.bar(v, jump));
      made.w_rad_per_s.fill(spreads[i].w.bar(w, jump));
      if (shared.empty()) continue;
      for (int c = 0; c < 3; ++c) {
        made.p_m[c] += more.bodies[i].p_m[c];
        made.v_m_per_s[c] += more.bodies[i].v_m_per_s[c];
        made.w_rad_per_s[c] += more.bodies[i].w_rad_per_s[c];
      }
      for (int c = 0; c < 4; ++c) made.q_wxyz[c] += more.bodies[i].q_wxyz[c];
    }
    if (samples.is_asked(k)) truth.bars.push_back(bar);
  }
}

// An impact within its bar of the release of one of its bodies: before it, the body is held.
void end_at_ties(const Scenario& scenario, const Truth& truth, std::optional<dynamics::CertifiedEnd>& end) {
  constexpr double ulps = 8 * 0x1p-52;
  for (std::size_t e = 0; e < truth.events.size(); ++e) {
    const Event& event = truth.events[e];
    for (const int body : {event.body_a, event.body_b}) {
      const Body& released = scenario.scene.bodies[body];
      const double apart_s = std::fabs(static_cast<double>(event.t_s - Wide(released.release_s)));
      if (released.fixed || !(released.release_s > 0) || event.kind != EventKind::impact ||
          apart_s > truth.event_bar_s[e] + ulps * released.release_s)
        continue;
      dynamics::end_at(end, event.t_s,
                       "CVODE: the release of `" + released.name + "` and the impact of `" +
                           scenario.scene.bodies[event.body_a].name + "` and `" +
                           scenario.scene.bodies[event.body_b].name + "`" + dynamics::at_time(event.t_s) +
                           " are closer in time than their bars, and the motion depends on their order");
    }
  }
}

// Adds the errors that the runs share to the events' bars, and cuts the events and `count`, the samples that all runs
// have, at the end of the certified part. Returns the half-widths of the samples; empty without contacts.
std::vector<std::vector<Wide>> add_shared_errors(const Samples& samples, Truth& truth, const std::vector<Solved>& runs,
                                                 std::optional<dynamics::CertifiedEnd>& end, std::size_t& count) {
  const Scenario& scenario = samples.scenario;
  const auto& instants = runs.front().record.instants;
  std::vector<std::vector<Wide>> made;
  if (!instants.empty()) {
    dynamics::SharedErrors shared =
        dynamics::shared_errors(scenario.scene, scenario.t_end_s, instants, truth.events, truth.event_bar_s,
                                differences(samples, runs, count), kRoundOff);
    for (std::size_t k = 0; k < truth.event_bar_s.size(); ++k) truth.event_bar_s[k] += shared.events_s[k];
    if (shared.end) dynamics::end_at(end, shared.end->t_s, "CVODE: " + shared.end->why);
    made = std::move(shared.samples);
  }
  end_at_ties(scenario, truth, end);
  const auto certified = [&](Wide t_s) { return !end || t_s == 0 || end->is_after(t_s); };
  while (count > 0 && !certified(samples.t_s(count - 1))) --count;
  while (end && !truth.events.empty() && !certified(truth.events.back().t_s)) {
    truth.events.pop_back();
    truth.event_bar_s.pop_back();
  }
  return made;
}

}  // namespace

Truth cvode_truth(const Scenario& scenario, std::int64_t samples) {
  if (!scenario.scene.joints.empty() || !scenario.scene.ropes.empty()) return cvode::mechanism_truth(scenario, samples);
  Truth truth;
  std::vector<Solved> runs;
  const bool known = dynamics::unsupported(scenario.scene).empty();
  if (known && dynamics::contacts_possible(scenario.scene) &&
      dynamics::layout(scenario.scene).size > dynamics::ErrorGrowth::kMaxUnknowns) {
    truth.outcome =
        refused("CVODE: contacts in a scene of more than " + std::to_string(dynamics::ErrorGrowth::kMaxUnknowns) +
                " unknowns are not covered; found " + std::to_string(dynamics::layout(scenario.scene).size));
    return truth;
  }
  const bool contacts = known && dynamics::contacts_possible(scenario.scene);
  const Samples of_runs{scenario, samples,
                        contacts && samples > 0 ? (kLeastCompared + samples - 1) / samples : std::int64_t{1}};
  const cvode::Scales scales = known ? scales_of(scenario) : cvode::Scales{};
  const double tight = contacts ? cvode::kTightContactRtol : cvode::kTightRtol,
               loose = contacts ? cvode::kLooseContactRtol : cvode::kLooseRtol;
  for (const double rtol : {tight, loose})
    for (const cvode::Family family : {cvode::Family::adams, cvode::Family::bdf}) {
      runs.push_back(solve(scenario, of_runs.count(), family, rtol, scales));
      if (runs.back().outcome.status != Status::ok && !runs.back().record.valid_until_failure) {
        truth.outcome = runs.back().outcome;
        return truth;
      }
      truth.outcome.steps_taken += runs.back().outcome.steps_taken;
      truth.outcome.rate_evaluations += runs.back().outcome.rate_evaluations;
    }
  truth.source = "cvode: SUNDIALS " + cvode::version() + ", Adams at rtol " + format_double(tight) +
                 "; bar: twice the largest difference, so far in the run, among Adams "
                 "and BDF at rtol " +
                 format_double(tight) + " and " + format_double(loose) +
                 " (atol = rtol / 100 of each kind's size), plus "
                 "1e-13 of the scale, plus round-off and the location of impacts grown along the motion";
  truth.events = runs.front().events;
  for (const Event& event : truth.events)
    truth.event_bar_s.push_back(
        static_cast<double>(kSafety * event_time_difference(event, runs) + Wide(kRelativeFloor) * fabsq(event.t_s)));
  std::optional<dynamics::CertifiedEnd> end = first_difference(scenario.scene, runs);
  std::size_t count = runs.front().record.states.size();
  for (const Solved& run : runs) count = std::min(count, run.record.states.size());
  const std::vector<std::vector<Wide>> shared = add_shared_errors(of_runs, truth, runs, end, count);
  const std::size_t rows = (count + of_runs.parts - 1) / of_runs.parts;
  truth.values.reserve(rows, scenario.scene.bodies.size());
  truth.bars.reserve(rows, scenario.scene.bodies.size());
  add_samples(of_runs, count, truth, runs, shared);
  truth.note = "CVODE's own differences: wider than a certified truth's bar";
  if (end) {
    truth.outcome.status = Status::unsupported;
    truth.outcome.reason = end->why;
  }
  return truth;
}

}  // namespace atwood
