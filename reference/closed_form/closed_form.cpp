#include "closed_form/closed_form.hpp"

#include <algorithm>
#include <cfenv>
#include <deque>
#include <map>
#include <optional>
#include <tuple>

#include "closed_form/joint_bars.hpp"
#include "closed_form/solution.hpp"
#include "closed_form/spread.hpp"
#include "protocol/refusal.hpp"

namespace atwood {

using namespace closed_form;

namespace {

const std::vector<Solution>& catalogue() {
  // clang-format off
  static const std::vector<Solution> all{ballistic(), linear_drag(), vertical_quadratic_drag(), oscillator(), kepler(),
                                         coulomb_two_body(), closed_form::lorentz(), free_rigid_body(), axis_torque(),
                                         bounce(), sphere_impact(), slide_or_roll(), steady_roll(),
                                         ball_flights(), friction_cone(), struck_rod(),
                                         penalty(), rest(), pendulum(), heavy_top(), linear_joint(), joint_stop(), turning_rod(),
                                         slider_crank(), hooke_shaft(), welded_bodies(), four_bar(),
                                         atwood_machine()};
  // clang-format on
  return all;
}

// The round-off of long double is 2^49 times that of quad. The difference of the same formulas between the two, divided
// by this ratio, estimates the round-off error of quad, including the conditioning of formulas and motion. One
// realisation of round-off may be small by chance; the bar therefore uses the largest difference over the four
// directions of rounding, over the run up to now and over the components of a kind, a factor of 16, and at least 16
// units in the last place of the scale. With impacts the rounding of one number, the first gap, determines the rest,
// and small differences by chance are more frequent: the factor is 64. (Rounded to nearest alone, with a factor of 32,
// 41 of 10 000 bounces left their bars, and so did an orbit of two charges.)
constexpr double kSmoothSafety = 16, kImpactSafety = 64;
// The start of a loop is projected onto its constraints to about 1e-31 only; the factor makes the start's rounding to
// long double, which both evaluations share otherwise, stand for that.
constexpr double kLoopSafety = 4096;
constexpr std::int64_t kInstantsAtOnce = 4096;
constexpr double kEndMargin = 1e-9;  // of the time: distance of the last sample from the end of the certified part

struct BodySpread {
  Spread p, q, v, w;
};

// Evaluations in long double, in each direction of rounding that has the impacts of rounding to nearest (close to a
// limit of validity a directed rounding may be refused).
using Realisations = std::vector<Motion<Narrow>>;

bool same_impacts(const Motion<Narrow>& a, const Motion<Narrow>& b) {
  return b.refusal.empty() && a.undecided == b.undecided && a.poses.size() == b.poses.size() &&
         std::equal(a.events.begin(), a.events.end(), b.events.begin(), b.events.end(),
                    [](const ContactEvent<Narrow>& x, const ContactEvent<Narrow>& y) {
                      return x.kind == y.kind && x.body_a == y.body_a && x.body_b == y.body_b;
                    });
}

// Some of the instants of samples + 1 samples: `count` from number `first` on, as far as there are so many.
struct Instants {
  std::int64_t samples = 0, first = 0, count = 0;
};

template <class S> std::vector<S> times_of(const Scenario& scenario, const Instants& at) {
  std::vector<S> t_s;
  for (std::int64_t k = at.first; k <= at.samples && k < at.first + at.count; ++k)
    t_s.push_back(S(scenario.t_end_s) * S(k) / S(at.samples));
  return t_s;
}

Event event_of(const ContactEvent<Wide>& from) {
  Event made;
  made.t_s = from.t_s;
  made.kind = from.kind;
  made.body_a = from.body_a;
  made.body_b = from.body_b;
  made.x_m = from.x_W;
  made.normal = from.normal_W;
  made.impulse_n_N_s = from.impulse_n_N_s;
  made.impulse_t_N_s = from.impulse_t_N_s;
  made.vn_before_m_per_s = from.vn_before_m_per_s;
  made.vn_after_m_per_s = from.vn_after_m_per_s;
  return made;
}

// Sets the direction of rounding, and restores it at the end of its scope, also after an exception.
struct Rounding {
  explicit Rounding(int direction) { std::fesetround(direction); }
  ~Rounding() { std::fesetround(before); }
  Rounding(const Rounding&) = delete;
  Rounding& operator=(const Rounding&) = delete;
  const int before = std::fegetround();
};

Realisations narrow_realisations(const Solution& solution, const Scenario& scenario, const Instants& at) {
  Realisations made;
  for (const int direction : {FE_TONEAREST, FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    const Rounding rounding(direction);
    Motion<Narrow> motion = solution.narrow(scenario, times_of<Narrow>(scenario, at));
    if (made.empty() || same_impacts(made.front(), motion)) made.push_back(std::move(motion));
    if (!made.front().refusal.empty()) break;
  }
  return made;
}

// The time of an impact, and its half-widths in quad and in long double.
struct Instant {
  int body_a = 0, body_b = 0;
  Wide t_s = 0, bar_s = 0, narrow_bar_s = 0;
};

// Impacts in the order of time. Within narrow_bar_s of an impact long double may have the velocity before it and quad
// the velocity after it. `widest`: the largest narrow_bar_s.
struct Impacts {
  std::vector<Instant> all;
  Wide widest = 0;
};

bool at_impact(const Impacts& impacts, int body, Wide t_s) {
  auto hit = std::lower_bound(impacts.all.begin(), impacts.all.end(), t_s - impacts.widest,
                              [](const Instant& a, Wide t) { return a.t_s < t; });
  for (; hit != impacts.all.end() && hit->t_s <= t_s + impacts.widest; ++hit)
    if ((hit->body_a == body || hit->body_b == body) && magnitude(hit->t_s - t_s) <= hit->narrow_bar_s) return true;
  return false;
}

// The farthest anchor from the centre of mass of its body; 0: there are no joints.
Wide longest_arm(const Scene& scene) {
  Wide arm = 0;
  for (const Joint& joint : scene.joints)
    for (const Real3& anchor : joint.anchors_body_m) arm = larger(arm, norm(vec<Wide>(anchor)));
  return arm;
}

// What the bars depend on from one sample to the next: the spreads and the largest sizes so far.
struct SpreadSoFar {
  SpreadSoFar(const Scene& scene, const Motion<Wide>& wide)
      : loops(std::any_of(scene.joints.begin(), scene.joints.end(), [](const Joint& j) { return j.closes_loop; })),
        safety(loops                 ? kLoopSafety
               : wide.events.empty() ? kSmoothSafety
                                     : kImpactSafety),
        bodies(scene.bodies.size()), joints(scene, safety, loops) {
    for (const Pose<Wide>& start : wide.poses.front()) places = larger(places, norm(start.p_WB));
  }

  bool loops = false;
  double safety = 0;
  std::vector<BodySpread> bodies;
  JointBars joints;
  MotionScales scales;
  Wide places = 0, speeds = 0, rates = 0;  // the largest of all bodies
};

// Answers the name of a body whose motion amplifies round-off too much for a bar; empty: there is none.
std::string add_samples(Truth& truth, const Scene& scene, const std::vector<Wide>& t_s, const Motion<Wide>& wide,
                        const Realisations& narrow, const Impacts& impacts, SpreadSoFar& so_far) {
  auto& [loops, safety, spreads, joint_bars, scales, places, speeds, rates] = so_far;
  const Wide noise = 1024 * unit_round_off<Narrow>() / kMeasureLimit;
  const bool jointed = !scene.joints.empty();
  const Wide arm = longest_arm(scene);
  for (std::size_t k = 0; k < t_s.size(); ++k) {
    const bool at_start = truth.values.empty();
    Sample value, bar;
    value.t_s = bar.t_s = t_s[k];
    for (const Pose<Wide>& w : wide.poses[k]) value.bodies.push_back({w.p_WB, w.q_WB, w.v_WB, w.w_WB_B});
    scales.include(value.bodies);
    for (std::size_t i = 0; i < spreads.size(); ++i) {
      const Pose<Wide>& w = wide.poses[k][i];
      BodySample& half_width = bar.bodies.emplace_back();
      half_width.q_wxyz = {};
      BodySpread& of = spreads[i];
      const bool in_impact_bar = at_impact(impacts, static_cast<int>(i), t_s[k]);
      for (const Motion<Narrow>& realisation : narrow) {
        const Pose<Narrow>& n = realisation.poses[k][i];
        of.p.include(w.p_WB, n.p_WB);
        of.q.include(w.q_WB, n.q_WB);
        if (in_impact_bar) continue;
        of.v.include(w.v_WB, n.v_WB);
        of.w.include(w.w_WB_B, n.w_WB_B);
      }
      if (at_start && scene.joints.empty()) continue;  // the poses of a mechanism are computed at the start, too
      places = larger(places, of.p.scale);
      speeds = larger(speeds, of.v.scale);
      rates = larger(rates, of.w.scale);
      if (jointed) speeds = larger(speeds, rates * places);      // a centre may rest on the axis of a turn
      if (t_s[k] > 0) speeds = larger(speeds, places / t_s[k]);  // samples at whole periods may all find it at rest
      if (!at_start && (!of.p.is_measure(of.v.scale * t_s[k] + noise * places) || !of.q.is_measure(1) ||
                        !of.v.is_measure(of.v.scale + noise * speeds) || !of.w.is_measure(of.w.scale + noise * rates)))
        return scene.bodies[i].name;
      // Joints place their child from anchor to anchor: a centre on the axis of a turn rests to the round-off of those.
      const Wide size = jointed ? scales.place_m + arm : Wide(0), rate = jointed ? scales.rate_rad_per_s : Wide(0),
                 speed = jointed ? scales.speed_m_per_s + rate * size : Wide(0);
      half_width.p_m.fill(of.p.bar(safety, size) + wide.input_round_off.p_m);
      half_width.q_wxyz.fill(of.q.bar(safety) + wide.input_round_off.q);
      half_width.v_m_per_s.fill(of.v.bar(safety, speed) + wide.input_round_off.v_m_per_s);
      half_width.w_rad_per_s.fill(of.w.bar(safety, rate) + wide.input_round_off.w_rad_per_s);
    }
    if (const std::string joint = joint_bars.add(k, wide, narrow, scales, value, bar); !joint.empty()) return joint;
    truth.values.push_back(value);
    truth.bars.push_back(bar);
  }
  return "";
}

// Answers the time at which long double has another impact than quad, so that the impact depends on round-off; empty:
// there is none. Impacts are compared pair by pair; impacts of different pairs at one time may come in either order.
std::string add_events(Truth& truth, const Scenario& scenario, const Motion<Wide>& wide, const Realisations& narrow,
                       std::optional<Wide> end_s, Impacts& impacts) {
  const std::vector<ContactEvent<Narrow>>& nearest = narrow.front().events;
  std::map<std::tuple<EventKind, int, int>, std::deque<std::size_t>> unmatched;  // indices of happenings
  for (std::size_t k = 0; k < nearest.size(); ++k)
    unmatched[{nearest[k].kind, nearest[k].body_a, nearest[k].body_b}].push_back(k);
  const Wide t_end = end_s.value_or(scenario.t_end_s),
             last = t_end * (1 - (end_s ? Wide(kEndMargin) : 64 * Wide(unit_round_off<Narrow>())));
  const auto when = [](Wide t_s) { return "at t = " + format_double(static_cast<double>(t_s)) + " s"; };
  for (const ContactEvent<Wide>& at : wide.events) {
    if (end_s && at.t_s >= last) break;
    std::deque<std::size_t>& matches = unmatched[{at.kind, at.body_a, at.body_b}];
    if (matches.empty() && at.t_s < last) return when(at.t_s);
    Wide difference = matches.empty() ? magnitude(t_end - at.t_s) : Wide(0);
    if (!matches.empty()) {
      for (const Motion<Narrow>& realisation : narrow)
        difference = larger(difference, magnitude(at.t_s - Wide(realisation.events[matches.front()].t_s)));
      matches.pop_front();
    }
    const Wide half_width = kImpactSafety * (ratio * difference + round_off * magnitude(at.t_s)) + at.slack_s;
    truth.events.push_back(event_of(at));
    truth.event_bar_s.push_back(static_cast<double>(half_width));
    impacts.all.push_back({at.body_a, at.body_b, at.t_s, half_width,
                           half_width + 2 * difference + 64 * unit_round_off<Narrow>() * magnitude(at.t_s)});
    impacts.widest = larger(impacts.widest, impacts.all.back().narrow_bar_s);
  }
  for (const auto& [pair, left] : unmatched)
    if (!left.empty() && nearest[left.front()].t_s < last) return when(nearest[left.front()].t_s);
  return "";
}

// A sample within the half-width of an impact's time may have the velocity before or after it.
void add_velocity_jumps(Truth& truth, const Scene& scene, const Motion<Wide>& wide,
                        const std::vector<Instant>& impacts) {
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    const auto from = std::lower_bound(truth.values.begin(), truth.values.end(), impacts[k].t_s - impacts[k].bar_s,
                                       [](const SampleView& sample, Wide t) { return sample.t_s < t; });
    const ContactEvent<Wide>& at = wide.events[k];
    if (at.vn_after_m_per_s == at.vn_before_m_per_s) continue;
    for (auto s = static_cast<std::size_t>(from - truth.values.begin()); s < truth.values.size(); ++s) {
      if (truth.values[s].t_s > at.t_s + impacts[k].bar_s) break;
      if (s == 0) continue;
      truth.note =
          "a sample is at the time of an impact: the bars of its velocity and angular velocity include the jump";
      if (!wide.joints.empty()) {
        add_stop_jump(scene, at, truth.values[s], truth.bars[s]);
        continue;
      }
      for (const int body : {at.body_a, at.body_b}) {
        for (Wide& v : truth.bars[s].bodies[body].v_m_per_s)
          v += magnitude(at.vn_after_m_per_s - at.vn_before_m_per_s) * (1 + at.impulse_t_N_s / at.impulse_n_N_s);
        const auto &before = truth.values[s - 1].bodies[body].w_rad_per_s,
                   &now = truth.values[s].bodies[body].w_rad_per_s;
        for (int i = 0; i < 3; ++i) truth.bars[s].bodies[body].w_rad_per_s[i] += magnitude(now[i] - before[i]);
      }
    }
  }
}

// The truth is certified for times before t_s; `why` says what is not decided there.
struct CertifiedEnd {
  Wide t_s = 0;
  std::string why;
};

std::optional<Wide> end_of(const std::optional<CertifiedEnd>& ending) {
  return ending ? std::optional<Wide>(ending->t_s) : std::nullopt;
}

std::optional<CertifiedEnd> first_undecided(const Motion<Wide>& wide, const Motion<Narrow>& narrow) {
  std::optional<CertifiedEnd> made;
  const auto see = [&](Wide t_s, const std::string& why) {
    if (why.empty() || (made && made->t_s <= t_s)) return;
    made = CertifiedEnd{t_s, why + " at t = " + format_double(static_cast<double>(t_s)) + " s"};
  };
  see(wide.end_s, wide.undecided);
  see(narrow.end_s, narrow.undecided);
  return made;
}

// The first impact whose bar contains another impact that is coupled with it: their order, and the motion after them,
// is not decided.
std::optional<CertifiedEnd> undecided_order(const Scene& scene, const Motion<Wide>& wide,
                                            const std::vector<Instant>& impacts) {
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    const ContactEvent<Wide>& at = wide.events[k];
    if (at.coupled_delay_s < 0 || at.coupled_delay_s > 4 * impacts[k].bar_s) continue;
    return CertifiedEnd{at.t_s, "another impact coupled with that of `" + scene.bodies[at.body_a].name + "` and `" +
                                    scene.bodies[at.body_b].name +
                                    "` at t = " + format_double(static_cast<double>(at.t_s)) +
                                    " s is within its bar, and the motion depends on their order"};
  }
  return std::nullopt;
}

// Is it above 1e-20 of the scene's size?
bool is_significant(const InputRoundOff<Wide>& input_round_off, const SampleView& start) {
  Wide size = 0;
  for (const BodySample& body : start.bodies)
    for (const Wide& p : body.p_m) size = larger(size, magnitude(p));
  return input_round_off.p_m > Wide(1e-20) * size || input_round_off.q > Wide(1e-20);
}

Truth unsupported(const Scenario& scenario, const std::string& why) {
  return refused<Truth>("closed form `" + scenario.truth.solution + "`: " + why);
}

}  // namespace

std::vector<std::string> closed_form_ids() {
  std::vector<std::string> ids;
  for (const Solution& solution : catalogue()) ids.push_back(solution.id);
  return ids;
}

Truth closed_form_truth(const Scenario& scenario, std::int64_t samples) {
  const auto found = std::find_if(catalogue().begin(), catalogue().end(),
                                  [&](const Solution& s) { return s.id == scenario.truth.solution; });
  if (found == catalogue().end()) {
    std::string known;
    for (const std::string& id : closed_form_ids()) known += (known.empty() ? "" : ", ") + id;
    return unsupported(scenario, "no such solution; expected one of " + known);
  }
  if (samples < 1) return unsupported(scenario, "expected at least 1 sample; found " + std::to_string(samples));
  if (const std::string what = first_uncovered(scenario, found->covers); !what.empty())
    return unsupported(scenario, what);
  // Evaluations of many samples take more memory than the truth itself.
  Instants at{samples, 0, found->each_instant_alone ? kInstantsAtOnce : samples + 1};
  std::vector<Wide> t_s = times_of<Wide>(scenario, at);
  Motion<Wide> wide = found->wide(scenario, t_s);
  if (!wide.refusal.empty()) return unsupported(scenario, wide.refusal);
  Realisations narrow = narrow_realisations(*found, scenario, at);
  const auto too_close = [&] { return "too close to a limit of its validity: " + narrow.front().refusal; };
  if (!narrow.front().refusal.empty()) return unsupported(scenario, too_close());
  Truth truth;
  truth.values.reserve(static_cast<std::size_t>(samples) + 1, scenario.scene.bodies.size());
  truth.bars.reserve(static_cast<std::size_t>(samples) + 1, scenario.scene.bodies.size());
  truth.source = std::string("closed form: ") + found->citation;
  std::optional<CertifiedEnd> ending = first_undecided(wide, narrow.front());
  Impacts impacts;
  if (const std::string when = add_events(truth, scenario, wide, narrow, end_of(ending), impacts); !when.empty())
    return unsupported(scenario,
                       "the impact " + when + " depends on round-off: quad and long double have different impacts");
  if (auto earlier = undecided_order(scenario.scene, wide, impacts.all)) {
    ending = std::move(earlier);
    truth.events.clear();
    truth.event_bar_s.clear();
    impacts = {};
    add_events(truth, scenario, wide, narrow, end_of(ending), impacts);
  }
  const auto is_certified = [&](Wide t) { return !ending || t < ending->t_s * (1 - Wide(kEndMargin)); };
  while (t_s.size() > 1 && !is_certified(t_s.back())) t_s.pop_back();
  SpreadSoFar so_far(scenario.scene, wide);
  while (!t_s.empty()) {
    if (const std::string body = add_samples(truth, scenario.scene, t_s, wide, narrow, impacts, so_far); !body.empty())
      return unsupported(scenario, "the motion of `" + body + "` amplifies round-off too much for a bar");
    at.first += at.count;
    t_s = times_of<Wide>(scenario, at);
    while (!t_s.empty() && !is_certified(t_s.back())) t_s.pop_back();
    if (t_s.empty()) break;
    wide = found->wide(scenario, t_s);
    if (!wide.refusal.empty()) return unsupported(scenario, wide.refusal);
    narrow = narrow_realisations(*found, scenario, at);
    if (!narrow.front().refusal.empty()) return unsupported(scenario, too_close());
  }
  if (is_significant(wide.input_round_off, truth.values.front()))
    truth.note = "deviations within the round-off of the scene's doubles (a gap, a tilt, a slip) are treated as zero";
  add_velocity_jumps(truth, scenario.scene, wide, impacts.all);
  for (const SampleView bar : truth.bars)
    for (const BodySample& body : bar.bodies)
      for (const auto* values : {&body.p_m, &body.v_m_per_s, &body.w_rad_per_s})
        for (const Wide& v : *values)
          if (!is_finite(v)) {
            Truth failed;
            failed.outcome.status = Status::not_finite;
            failed.outcome.reason = "closed form `" + scenario.truth.solution + "` is not finite for this scene";
            return failed;
          }
  if (ending) {
    truth.outcome = refused("closed form `" + scenario.truth.solution + "`: " + ending->why);
  }
  return truth;
}

}  // namespace atwood
