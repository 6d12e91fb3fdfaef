#include "closed_form/closed_form.hpp"

#include <algorithm>
#include <cfenv>
#include <deque>
#include <map>
#include <optional>
#include <tuple>

#include "closed_form/solution.hpp"

namespace atwood {

using namespace closed_form;

namespace {

const std::vector<Solution>& catalogue() {
  // clang-format off
  static const std::vector<Solution> all{ballistic(), linear_drag(), vertical_quadratic_drag(), oscillator(), kepler(),
                                         coulomb_two_body(), closed_form::lorentz(), free_rigid_body(), axis_torque(),
                                         bounce(), sphere_impact(), slide_or_roll(), steady_roll(),
                                         ball_flights(), friction_cone(), struck_rod(),
                                         penalty(), rest()};
  // clang-format on
  return all;
}

// Round-off of long double is 2^49 times that of quad: the same formulas' difference between the two is, scaled, what
// quad's own round-off does to the value, through whatever conditioning the formulas and the motion have. One
// realisation of round-off may be lucky: hence the largest difference over the run so far and over the components of a
// kind, a factor of 32, and 32 units in the last place of the scale as the least. With impacts the rounding of one
// number, the first gap, decides all that follows, and luck is likelier (41 of 10 000 bounces left their bars): there
// long double rounds in its four directions, and the factor is 64.
constexpr double kSmoothSafety = 32, kImpactSafety = 64;
const Wide round_off = unit_round_off<Wide>();
const Wide ratio = unit_round_off<Wide>() / unit_round_off<Narrow>();
const Wide proportional = 0x1p-20;
constexpr double kEndMargin = 1e-9;  // of the time: how long before the end of what is certified the samples stop

struct Spread {  // one kind of value of one body, over the run so far
  Wide difference = 0, scale = 0;
  template <class A, class B> void see(const A& wide, const B& narrow) {
    for (std::size_t i = 0; i < wide.size(); ++i) {
      difference = larger(difference, magnitude(wide[i] - Wide(narrow[i])));
      if (!is_finite(wide[i]) || !is_finite(narrow[i])) difference = std::numeric_limits<double>::infinity();
      scale = larger(scale, magnitude(wide[i]));
    }
  }
  Wide bar(double safety) const { return safety * (ratio * difference + round_off * scale); }
  // The difference grows in proportion to the round-off only while it is small beside the motion itself (`way`: its
  // extent, and what round-off alone does to numbers of the scene's size): past that it is no longer a measure of what quad's own round-off does.
  bool trusted(Wide way) const { return difference <= proportional * way || !is_finite(difference); }
};

struct BodySpread {
  Spread p, q, v, w;
};

// Evaluations in long double: to nearest; with impacts in the other directions of rounding too, as far as they see the
// same ones (beside a limit of validity a directed rounding may fall on its other side).
using Realisations = std::vector<Motion<Narrow>>;

bool same_impacts(const Motion<Narrow>& a, const Motion<Narrow>& b) {
  return b.misfit.empty() && a.branch == b.branch && a.poses.size() == b.poses.size() &&
         std::equal(a.happenings.begin(), a.happenings.end(), b.happenings.begin(), b.happenings.end(),
                    [](const Happening<Narrow>& x, const Happening<Narrow>& y) {
                      return x.kind == y.kind && x.body_a == y.body_a && x.body_b == y.body_b;
                    });
}

template <class S> std::vector<S> instants(const Scenario& scenario, std::int64_t samples) {
  std::vector<S> t_s;
  for (std::int64_t k = 0; k <= samples; ++k) t_s.push_back(S(scenario.t_end_s) * S(k) / S(samples));
  return t_s;
}

Event event_of(const Happening<Wide>& from) {
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

// The direction of rounding while it lives; restored whatever ends the evaluation, memory that is short too.
struct Rounding {
  explicit Rounding(int direction) { std::fesetround(direction); }
  ~Rounding() { std::fesetround(before); }
  Rounding(const Rounding&) = delete;
  Rounding& operator=(const Rounding&) = delete;
  const int before = std::fegetround();
};

Realisations narrow_realisations(const Solution& solution, const Scenario& scenario, std::int64_t samples) {
  Realisations made;
  for (const int direction : {FE_TONEAREST, FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    const Rounding rounding(direction);
    Motion<Narrow> motion = solution.narrow(scenario, instants<Narrow>(scenario, samples));
    if (made.empty() || same_impacts(made.front(), motion)) made.push_back(std::move(motion));
    if (!made.front().misfit.empty() || made.front().happenings.empty()) break;
  }
  return made;
}

// An impact's instant, and how far off it may be: in quad, in long double.
struct Instant {
  int body_a = 0, body_b = 0;
  Wide t_s = 0, bar_s = 0, narrow_bar_s = 0;
};

// At an impact's instant long double may show the velocity before it where quad shows the one after it. In the order
// of time, as impacts come; `widest`: of their narrow bars.
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

// Empty, or which body's motion magnifies round-off too much for a bar.
std::string add_samples(Truth& truth, const Scene& scene, const std::vector<Wide>& t_s, const Motion<Wide>& wide,
                        const Realisations& narrow, const Impacts& impacts) {
  if (t_s.empty()) return "";
  const double safety = wide.happenings.empty() ? kSmoothSafety : kImpactSafety;
  std::vector<BodySpread> spreads(wide.poses.front().size());
  const Wide noise = 1024 * unit_round_off<Narrow>() / proportional;
  Wide places = 0, speeds = 0, rates = 0;  // the largest so far of all bodies
  for (const Pose<Wide>& start : wide.poses.front()) places = larger(places, norm(start.p_WB));
  for (std::size_t k = 0; k < t_s.size(); ++k) {
    Sample &value = truth.values.emplace_back(), &bar = truth.bars.emplace_back();
    value.t_s = bar.t_s = t_s[k];
    for (std::size_t i = 0; i < spreads.size(); ++i) {
      const Pose<Wide>& w = wide.poses[k][i];
      value.bodies.push_back({w.p_WB, w.q_WB, w.v_WB, w.w_WB_B});
      BodySample& half_width = bar.bodies.emplace_back();
      half_width.q_wxyz = {};
      BodySpread& of = spreads[i];
      const bool jumps = at_impact(impacts, static_cast<int>(i), t_s[k]);
      for (const Motion<Narrow>& realisation : narrow) {
        const Pose<Narrow>& n = realisation.poses[k][i];
        of.p.see(w.p_WB, n.p_WB);
        of.q.see(w.q_WB, n.q_WB);
        if (jumps) continue;
        of.v.see(w.v_WB, n.v_WB);
        of.w.see(w.w_WB_B, n.w_WB_B);
      }
      if (k == 0) continue;
      places = larger(places, of.p.scale);
      speeds = larger(speeds, of.v.scale);
      rates = larger(rates, of.w.scale);
      if (!of.p.trusted(of.v.scale * t_s[k] + noise * places) || !of.q.trusted(1) ||
          !of.v.trusted(of.v.scale + noise * speeds) || !of.w.trusted(of.w.scale + noise * rates))
        return scene.bodies[i].name;
      half_width.p_m.fill(of.p.bar(safety) + wide.slack.p_m);
      half_width.q_wxyz.fill(of.q.bar(safety) + wide.slack.q);
      half_width.v_m_per_s.fill(of.v.bar(safety) + wide.slack.v_m_per_s);
      half_width.w_rad_per_s.fill(of.w.bar(safety) + wide.slack.w_rad_per_s);
    }
  }
  return "";
}

// Empty, or when long double sees another impact than quad: whether two bodies meet hangs on round-off. Each pair's
// impacts are compared in their order; impacts of different pairs at one instant may come in either.
std::string add_events(Truth& truth, const Scenario& scenario, const Motion<Wide>& wide, const Realisations& narrow,
                       std::optional<Wide> end_s, Impacts& impacts) {
  const std::vector<Happening<Narrow>>& nearest = narrow.front().happenings;
  std::map<std::tuple<EventKind, int, int>, std::deque<std::size_t>> also;  // indices of happenings
  for (std::size_t k = 0; k < nearest.size(); ++k)
    also[{nearest[k].kind, nearest[k].body_a, nearest[k].body_b}].push_back(k);
  const Wide t_end = end_s.value_or(scenario.t_end_s),
             last = t_end * (1 - (end_s ? Wide(kEndMargin) : 64 * Wide(unit_round_off<Narrow>())));
  const auto when = [](Wide t_s) { return "at t = " + format_double(static_cast<double>(t_s)) + " s"; };
  for (const Happening<Wide>& at : wide.happenings) {
    if (end_s && at.t_s >= last) break;
    std::deque<std::size_t>& twins = also[{at.kind, at.body_a, at.body_b}];
    if (twins.empty() && at.t_s < last) return when(at.t_s);
    Wide difference = twins.empty() ? magnitude(t_end - at.t_s) : Wide(0);
    if (!twins.empty()) {
      for (const Motion<Narrow>& realisation : narrow)
        difference = larger(difference, magnitude(at.t_s - Wide(realisation.happenings[twins.front()].t_s)));
      twins.pop_front();
    }
    const Wide half_width = kImpactSafety * (ratio * difference + round_off * magnitude(at.t_s));
    truth.events.push_back(event_of(at));
    truth.event_bar_s.push_back(static_cast<double>(half_width));
    impacts.all.push_back({at.body_a, at.body_b, at.t_s, half_width,
                           half_width + 2 * difference + 64 * unit_round_off<Narrow>() * magnitude(at.t_s)});
    impacts.widest = larger(impacts.widest, impacts.all.back().narrow_bar_s);
  }
  for (const auto& [pair, left] : also)
    if (!left.empty() && nearest[left.front()].t_s < last) return when(nearest[left.front()].t_s);
  return "";
}

// A sample at the very instant of an impact may show the velocity before or after it.
void hold_jumps(Truth& truth, const Motion<Wide>& wide, const std::vector<Instant>& impacts) {
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    const auto from = std::lower_bound(truth.values.begin(), truth.values.end(), impacts[k].t_s - impacts[k].bar_s,
                                       [](const Sample& sample, Wide t) { return sample.t_s < t; });
    const Happening<Wide>& at = wide.happenings[k];
    if (at.vn_after_m_per_s == at.vn_before_m_per_s) continue;
    for (auto s = static_cast<std::size_t>(from - truth.values.begin()); s < truth.values.size(); ++s) {
      if (truth.values[s].t_s > at.t_s + impacts[k].bar_s) break;
      if (s == 0) continue;
      for (const int body : {at.body_a, at.body_b}) {
        for (Wide& v : truth.bars[s].bodies[body].v_m_per_s)
          v += magnitude(at.vn_after_m_per_s - at.vn_before_m_per_s) * (1 + at.impulse_t_N_s / at.impulse_n_N_s);
        const auto &before = truth.values[s - 1].bodies[body].w_rad_per_s,
                   &now = truth.values[s].bodies[body].w_rad_per_s;
        for (int i = 0; i < 3; ++i) truth.bars[s].bodies[body].w_rad_per_s[i] += magnitude(now[i] - before[i]);
      }
      truth.note = "a sample falls on the instant of an impact: the bars of its velocity and spin hold the jump";
    }
  }
}

// Where what is certified ends, and why.
struct Ending {
  Wide t_s = 0;
  std::string why;
};

std::optional<Wide> end_of(const std::optional<Ending>& ending) {
  return ending ? std::optional<Wide>(ending->t_s) : std::nullopt;
}

std::optional<Ending> branch_of(const Motion<Wide>& wide, const Motion<Narrow>& narrow) {
  std::optional<Ending> made;
  const auto see = [&](Wide t_s, const std::string& why) {
    if (why.empty() || (made && made->t_s <= t_s)) return;
    made = Ending{t_s, why + " at t = " + format_double(static_cast<double>(t_s)) + " s"};
  };
  see(wide.end_s, wide.branch);
  see(narrow.end_s, narrow.branch);
  return made;
}

// The first impact beside which another, that acts on it, would have come within both bars: their order is not known,
// and what follows hangs on it.
std::optional<Ending> rival_within_bars(const Scene& scene, const Motion<Wide>& wide,
                                        const std::vector<Instant>& impacts) {
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    const Happening<Wide>& at = wide.happenings[k];
    if (at.rival_s < 0 || at.rival_s > 4 * impacts[k].bar_s) continue;
    return Ending{at.t_s, "another impact beside that of `" + scene.bodies[at.body_a].name + "` and `" +
                              scene.bodies[at.body_b].name + "` at t = " + format_double(static_cast<double>(at.t_s)) +
                              " s cannot be told apart from it in time, and their order decides what follows"};
  }
  return std::nullopt;
}

// Is it more than 1e-20 of the scene's size?
bool shows(const Slack<Wide>& slack, const Sample& start) {
  Wide size = 0;
  for (const BodySample& body : start.bodies)
    for (const Wide& p : body.p_m) size = larger(size, magnitude(p));
  return slack.p_m > Wide(1e-20) * size || slack.q > Wide(1e-20);
}

Truth unsupported(const Scenario& scenario, const std::string& why) {
  Truth truth;
  truth.outcome.status = Status::unsupported;
  truth.outcome.reason = "closed form `" + scenario.truth.solution + "`: " + why;
  return truth;
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
    return unsupported(scenario, "no such solution; known are " + known);
  }
  if (samples < 1) return unsupported(scenario, "no samples asked for");
  if (const std::string what = not_taken(scenario, found->takes); !what.empty()) return unsupported(scenario, what);
  std::vector<Wide> t_s = instants<Wide>(scenario, samples);
  const Motion<Wide> wide = found->wide(scenario, t_s);
  if (!wide.misfit.empty()) return unsupported(scenario, wide.misfit);
  const Realisations narrow = narrow_realisations(*found, scenario, samples);
  if (const std::string& misfit = narrow.front().misfit; !misfit.empty())
    return unsupported(scenario, "too near a limit of validity: " + misfit);
  Truth truth;
  truth.source = std::string("closed form: ") + found->citation;
  std::optional<Ending> ending = branch_of(wide, narrow.front());
  Impacts impacts;
  if (const std::string when = add_events(truth, scenario, wide, narrow, end_of(ending), impacts); !when.empty())
    return unsupported(scenario, "which bodies meet " + when + " hangs on the last digits");
  if (auto earlier = rival_within_bars(scenario.scene, wide, impacts.all)) {
    ending = std::move(earlier);
    truth.events.clear();
    truth.event_bar_s.clear();
    impacts = {};
    add_events(truth, scenario, wide, narrow, end_of(ending), impacts);
  }
  while (ending && t_s.size() > 1 && t_s.back() >= ending->t_s * (1 - Wide(kEndMargin))) t_s.pop_back();
  if (const std::string body = add_samples(truth, scenario.scene, t_s, wide, narrow, impacts); !body.empty())
    return unsupported(scenario, "the motion of `" + body + "` magnifies round-off too much for a bar");
  if (shows(wide.slack, truth.values.front()))
    truth.note =
        "parts within the round-off of the scene's doubles (an open contact, a tilt, a slip) are taken for none";
  hold_jumps(truth, wide, impacts.all);
  for (const Sample& bar : truth.bars)
    for (const BodySample& body : bar.bodies)
      for (const auto* values : {&body.p_m, &body.v_m_per_s, &body.w_rad_per_s})
        for (const Wide& v : *values)
          if (!is_finite(v)) {
            Truth failed;
            failed.outcome.status = Status::not_finite;
            failed.outcome.reason = "closed form `" + scenario.truth.solution + "` is not finite on this scene";
            return failed;
          }
  if (ending) {
    truth.outcome.status = Status::unsupported;
    truth.outcome.reason = "closed form `" + scenario.truth.solution + "`: " + ending->why;
  }
  return truth;
}

}  // namespace atwood
