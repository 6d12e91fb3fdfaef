#include <quadmath.h>

#include <algorithm>

#include "cvode/cvode.hpp"
#include "cvode/run.hpp"

namespace atwood {

namespace {

constexpr double loose = 1e-10, tight = 1e-12;
constexpr double safety = 2;
constexpr double least = 1e-13;  // of the scale so far: double's round-off over a run

struct Solved {
  std::vector<Sample> values;
  std::vector<Event> events;
  Outcome outcome;
};

Solved solve(const Scenario& scenario, std::int64_t samples, cvode::Family family, double rtol) {
  cvode::Options options;
  options.family = family;
  options.rtol = rtol;
  options.atol = rtol / 100;
  options.max_order = family == cvode::Family::adams ? 12 : 5;
  Solved made;
  made.outcome = cvode::run(
      scenario.scene, scenario.t_end_s, samples, options,
      {[&](const Sample& s) { made.values.push_back(s); }, [&](const Event& e) { made.events.push_back(e); }});
  if (made.outcome.status != Status::ok)
    made.outcome.reason += std::string(" (") + (family == cvode::Family::adams ? "Adams" : "BDF") + " at rtol " +
                           format_double(rtol) + ")";
  return made;
}

// The time by which the runs disagree on an event, against the nearest of the same kind and pair.
Wide spread_of(const Event& event, const std::vector<Solved>& runs) {
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

struct Spread {  // one kind of value of one body
  Wide difference = 0, scale = 0;
  // The largest difference so far makes the bar: errors cross zero. At an impact the runs differ by the jump for as
  // long as they disagree on its instant: that belongs to this sample alone.
  template <std::size_t N>
  Wide bar(const std::vector<const std::array<Wide, N>*>& all, bool at_impact) {
    Wide now = 0;
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t a = 0; a < all.size(); ++a)
        for (std::size_t b = 0; b < a; ++b) now = fmaxq(now, fabsq((*all[a])[i] - (*all[b])[i]));
      scale = fmaxq(scale, fabsq((*all[0])[i]));
    }
    if (!at_impact) difference = fmaxq(difference, now);
    return safety * fmaxq(difference, now) + least * scale;
  }
};

// Between the last bounce that was followed and the rest the ball still bounces, lower than the runs resolve: what it
// may then have of speed and height, by the last speed that it left with.
struct Unresolved { Wide speed = 0, height = 0; };
Unresolved unresolved(const std::vector<Event>& events, int body, Wide t_s, double slack_s) {
  Unresolved made;
  for (std::size_t r = 0; r < events.size(); ++r) {
    const Event& rest = events[r];
    if (rest.kind != EventKind::rest || (rest.body_a != body && rest.body_b != body)) continue;
    for (std::size_t k = r; k-- > 0;) {
      const Event& last = events[k];
      if (last.body_a != rest.body_a || last.body_b != rest.body_b) continue;
      if (t_s >= last.t_s - slack_s && t_s <= rest.t_s + slack_s)
        made = {fabsq(last.vn_after_m_per_s), fabsq(last.vn_after_m_per_s) * (rest.t_s - last.t_s)};
      break;
    }
  }
  return made;
}

// An error d of the positions at an impact of two spheres turns the line of centres by d / (r_a + r_b), and with it the
// change of velocity. The four runs share that error where it is the round-off of the root's location (CVODE: 100 units
// in the last place of the time), so it is added rather than seen in their differences.
class Turned {
 public:
  Turned(const Scene& scene, const std::vector<Event>& events)
      : scene_(scene), events_(events), kicks_(scene.bodies.size()) {}

  // Events up to t_s, with the bars of the sample before.
  void pass(Wide t_s, const Sample* before) {
    for (; next_ < events_.size() && events_[next_].t_s <= t_s; ++next_) {
      const Event& event = events_[next_];
      const auto* a = std::get_if<Sphere>(&scene_.bodies[event.body_a].shape);
      const auto* b = std::get_if<Sphere>(&scene_.bodies[event.body_b].shape);
      if (a == nullptr || b == nullptr) continue;
      Wide off = 100 * 0x1p-52 * fabsq(event.t_s * event.vn_before_m_per_s), size = 0;
      for (const int body : {event.body_a, event.body_b}) {
        for (int k = 0; k < 3; ++k) size = fmaxq(size, fabsq(event.x_m[k]));
        if (before != nullptr) off += 2 * before->bodies[body].p_m[0];
      }
      off += 8 * 0x1p-52 * size;
      const Wide kick =
          fabsq(event.vn_after_m_per_s - event.vn_before_m_per_s) * off / (Wide(a->radius_m) + b->radius_m);
      for (const int body : {event.body_a, event.body_b}) kicks_[body].push_back({event.t_s, safety * kick});
    }
  }
  Wide speed(int body) const {
    Wide sum = 0;
    for (const Kick& kick : kicks_[body]) sum += kick.speed;
    return sum;
  }
  Wide way(int body, Wide t_s) const {
    Wide sum = 0;
    for (const Kick& kick : kicks_[body]) sum += kick.speed * fmaxq(t_s - kick.t_s, 0);
    return sum;
  }

 private:
  struct Kick { Wide t_s = 0, speed = 0; };
  const Scene& scene_;
  const std::vector<Event>& events_;
  std::vector<std::vector<Kick>> kicks_;
  std::size_t next_ = 0;
};

void add_bars(const Scene& scene, Truth& truth, const std::vector<Solved>& runs) {
  struct BodySpread { Spread p, q, v, w; };
  std::vector<BodySpread> spreads(truth.values.front().bodies.size());
  Turned turned(scene, truth.events);
  for (std::size_t k = 0; k < truth.values.size(); ++k) {
    turned.pass(truth.values[k].t_s, k > 0 ? &truth.bars[k - 1] : nullptr);
    Sample& bar = truth.bars.emplace_back();
    bar.t_s = truth.values[k].t_s;
    for (std::size_t i = 0; i < spreads.size(); ++i) {
      BodySample& made = bar.bodies.emplace_back();
      made.q_wxyz = {};
      if (k == 0) continue;
      Wide jump = 0;
      for (std::size_t e = 0; e < truth.events.size(); ++e) {
        const Event& event = truth.events[e];
        if (event.body_a != static_cast<int>(i) && event.body_b != static_cast<int>(i)) continue;
        if (fabsq(event.t_s - bar.t_s) <= truth.event_bar_s[e])
          jump += fabsq(event.vn_after_m_per_s - event.vn_before_m_per_s);
      }
      std::vector<const std::array<Wide, 3>*> p, v, w;
      std::vector<const std::array<Wide, 4>*> q;
      for (const Solved& run : runs) {
        const BodySample& body = run.values[k].bodies[i];
        p.push_back(&body.p_m);
        q.push_back(&body.q_wxyz);
        v.push_back(&body.v_m_per_s);
        w.push_back(&body.w_rad_per_s);
      }
      const double slack_s = least * static_cast<double>(bar.t_s);
      const Unresolved low = unresolved(truth.events, static_cast<int>(i), bar.t_s, slack_s);
      made.p_m.fill(spreads[i].p.bar(p, false) + low.height + turned.way(static_cast<int>(i), bar.t_s));
      made.q_wxyz.fill(spreads[i].q.bar(q, false));
      made.v_m_per_s.fill(spreads[i].v.bar(v, jump > 0) + jump + low.speed + turned.speed(static_cast<int>(i)));
      made.w_rad_per_s.fill(spreads[i].w.bar(w, false));
    }
  }
}

}  // namespace

Truth cvode_truth(const Scenario& scenario, std::int64_t samples) {
  Truth truth;
  std::vector<Solved> runs;
  for (const double rtol : {tight, loose})
    for (const cvode::Family family : {cvode::Family::adams, cvode::Family::bdf}) {
      runs.push_back(solve(scenario, samples, family, rtol));
      if (runs.back().outcome.status != Status::ok) {
        truth.outcome = runs.back().outcome;
        return truth;
      }
      truth.outcome.steps_taken += runs.back().outcome.steps_taken;
      truth.outcome.rate_evaluations += runs.back().outcome.rate_evaluations;
    }
  truth.source = "cvode: SUNDIALS " + cvode::version() +
                 ", Adams at rtol 1e-12; bar: twice the largest difference, so far "
                 "in the run, among Adams and BDF at rtol 1e-12 and 1e-10 (atol = rtol / 100), plus 1e-13 of the scale";
  truth.values = runs.front().values;
  truth.events = runs.front().events;
  for (const Event& event : truth.events)
    truth.event_bar_s.push_back(static_cast<double>(safety * spread_of(event, runs) + Wide(least) * fabsq(event.t_s)));
  add_bars(scenario.scene, truth, runs);
  truth.note = "CVODE's own differences: wider than a certified truth's bar";
  return truth;
}

}  // namespace atwood
