#include "extended/impacts.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "dynamics/arithmetic.hpp"
#include "dynamics/last_bounces.hpp"

namespace atwood::extended {

using dynamics::Gap;
using dynamics::gap;
using dynamics::magnitude;

namespace {

template <class S> constexpr bool is_wide = std::is_same_v<S, Wide>;
template <class S>
constexpr double kGapRoundOff = is_wide<S> ? 1e-27 : 1e-11;  // of the places that a gap is the difference of
// Flights shorter than this part of the run are summed as a geometric series, if that leaves the time of rest open by
// no more than `rest_slack` of the run; and in any case those shorter than `least_flight`.
template <class S> constexpr double kLastFlight = is_wide<S> ? 1e-10 : 1e-4;
template <class S> constexpr double kLeastFlight = is_wide<S> ? 1e-12 : 1e-4;
constexpr double kRestSlack = 1e-24;
// Of a gap's round-off: the next impact of a lower flight would not be located.
template <class S> constexpr double kLeastHeight = is_wide<S> ? 1e3 : 4;
// Impacts in a row during which the time advances by less than a unit in its last place: there is no progress.
constexpr int kMostStalled = 1000;
constexpr double kNear = 1e-3;  // of the pair's size: a passage worth telling

template <class S> S reach(const Scene& scene, const dynamics::Layout& layout, int body, const S* y) {
  const Body& given = scene.bodies[body];
  if (const auto* plane = std::get_if<Plane>(&given.shape)) return std::fabs(plane->offset_m);
  S sum = 0;
  if (const auto* sphere = std::get_if<Sphere>(&given.shape)) sum = sphere->radius_m;
  const int at = layout.slots[body].position;
  for (int k = 0; k < 3; ++k) sum += at < 0 ? S(std::fabs(given.position_m[k])) : magnitude(y[at + k]);
  return sum;
}

template <class S> Event event_at(S t, EventKind kind, const dynamics::ContactPair& pair, const Gap<S>& where) {
  Event made;
  made.t_s = t;
  made.kind = kind;
  made.body_a = pair.a;
  made.body_b = pair.b;
  for (int k = 0; k < 3; ++k) {
    made.x_m[k] = where.x_m[k];
    made.normal[k] = where.normal[k];
  }
  return made;
}

}  // namespace

template <class S>
Impacts<S>::Impacts(const Scene& scene, dynamics::Dynamics<S>& dynamics, dynamics::Dynamics<double>& narrow,
                    double t_end_s)
    : scene_(scene), dynamics_(dynamics), narrow_(narrow), t_end_s_(t_end_s), fastest_(scene.bodies.size(), S(0)) {
  const dynamics::ContactPairs found = dynamics::contact_pairs(scene);
  pairs_ = found.pairs;
  if (!found.unsupported.empty()) failure_ = found.unsupported + " is not covered by the extended truth";
  for (const Pair& pair : pairs_)
    if (pair.gives)
      failure_ = "the contact of `" + scene.bodies[pair.a].name + "` and `" + scene.bodies[pair.b].name +
                 "`, which gives way, is not covered by the extended truth";
}

template <class S> S Impacts<S>::tiny(const Pair& pair, const S* y) const {
  return S(kGapRoundOff<S>) *
         (reach(scene_, dynamics_.layout(), pair.a, y) + reach(scene_, dynamics_.layout(), pair.b, y));
}

template <class S> S Impacts<S>::slow(const Pair& pair) const {
  return S(kGapRoundOff<S>) * (fastest_[pair.a] + fastest_[pair.b]);
}

template <class S> void Impacts<S>::see_speeds(const S* y) {
  for (std::size_t i = 0; i < fastest_.size(); ++i) {
    const int at = dynamics_.layout().slots[i].velocity;
    for (int k = 0; k < 3 && at >= 0; ++k) fastest_[i] = std::max(fastest_[i], magnitude(y[at + k]));
  }
}

// May the pair be struck at all? Fills failure() if not.
template <class S> bool Impacts<S>::may_strike(const Pair& pair, S t, const S* y) {
  const auto name = [&](int body) { return "`" + scene_.bodies[body].name + "`"; };
  for (const int body : {pair.a, pair.b})
    if (!scene_.bodies[body].fixed && scene_.bodies[body].release_s > t)
      failure_ = name(body) + " is struck before its release: not covered by the extended truth";
  for (const Pair& other : held_)
    for (const int body : {pair.a, pair.b})
      if (body == dynamics::ball_of(scene_, other) && dynamics::couple(scene_, dynamics_.layout(), pair, other, y)) {
        failure_ = name(body) + " is struck while it rests: not covered by the extended truth";
        branch_ = true;
      }
  if (const std::string why = dynamics::unstrikable(scene_, pair); !why.empty())
    failure_ = why + " is not covered by the extended truth";
  return failure_.empty();
}

template <class S>
void Impacts<S>::tell(const dynamics::Blow<S>& blow, const S* after, S t, std::vector<Event>& events) const {
  for (std::size_t k = 0; k < blow.pairs.size(); ++k) {
    const Gap<S> before = gap(scene_, dynamics_.layout(), blow.pairs[k], blow.before.data());
    if (!(blow.impulses[k].normal_N_s > 0)) continue;
    Event made = event_at(t, EventKind::impact, blow.pairs[k], before);
    made.impulse_n_N_s = blow.impulses[k].normal_N_s;
    made.impulse_t_N_s = blow.impulses[k].tangential_N_s;
    made.vn_before_m_per_s = before.rate_m_per_s;
    made.vn_after_m_per_s = gap(scene_, dynamics_.layout(), blow.pairs[k], after).rate_m_per_s;
    events.push_back(made);
  }
}

// Counts impacts, not their number but whether the time advances.
template <class S> void Impacts<S>::advances(S t) {
  const S unit = is_wide<S> ? S(0x1p-112) : S(0x1p-52);
  stalled_ = last_strike_ >= 0 && t - last_strike_ <= unit * t ? stalled_ + 1 : 0;
  last_strike_ = t;
  if (stalled_ > kMostStalled)
    failure_ = "the time does not advance over " + std::to_string(kMostStalled) +
               " impacts at t = " + format_double(static_cast<double>(t)) + " s";
}

template <class S>
std::optional<Laid<S>> Impacts<S>::rests(const Pair& pair, S t, S* y, int interval, std::vector<Event>& events) {
  const dynamics::LastBounces<S> last = dynamics::last_bounces(scene_, dynamics_, pair, t, y, interval, slow(pair));
  if (!last.pulled || (pair.restitution >= 1 && !last.lies)) return {};
  const Gap<S> now = gap(scene_, dynamics_.layout(), pair, y);
  const S height = magnitude(now.rate_m_per_s) * last.flight_s / 4;
  const bool located = height > S(kLeastHeight<S>) * tiny(pair, y);
  if (located && last.flight_s > kLastFlight<S> * t_end_s_) return {};
  const int ball = last.laid.ball;
  if (ball < 0) {
    failure_ = "`" + scene_.bodies[pair.a].name + "` and `" + scene_.bodies[pair.b].name +
               "` come to rest on each other: not covered by the extended truth";
    return {};
  }
  if (dynamics::rubs(scene_, dynamics_.layout(), pair, y, last.dydt.data(), slow(pair))) {
    failure_ =
        "`" + scene_.bodies[ball].name +
        "` comes to rest on a plane with friction, and slides or is pulled along: not covered by the extended truth";
    return {};
  }
  const bool known = last.ends && last.laid.bar_s <= kRestSlack * t_end_s_;
  if (!known && located && last.flight_s > kLeastFlight<S> * t_end_s_) return {};
  if (!last.ends) {
    failure_ = "when `" + scene_.bodies[ball].name + "` comes to rest is not decided: its restitution is too kNear 1";
    return {};
  }
  Laid<S> made = last.laid;
  made.told = made.until <= t_end_s_ && (t > 0 || magnitude(now.rate_m_per_s) > 0);
  std::copy(last.held.begin(), last.held.end(), y);
  dynamics_.hold_on_plane(ball, made.normal);
  narrow_.hold_on_plane(ball, made.normal);
  if (made.told) events.push_back(event_at(made.until, EventKind::rest, pair, now));
  return made;
}

template <class S> Instant<S> Impacts<S>::settle(S t, S* y, int interval, std::vector<Event>& events) {
  Instant<S> made;
  made.t = t;
  made.interval = interval;
  made.first_event = events.size();
  see_speeds(y);
  if (t == 0)
    for (const Pair& pair : pairs_)
      if (gap(scene_, dynamics_.layout(), pair, y).gap_m < -1e18 * tiny(pair, y))
        failure_ = "`" + scene_.bodies[pair.a].name + "` and `" + scene_.bodies[pair.b].name + "` overlap at the start";
  for (bool changed = true; changed && failure_.empty();) {
    changed = false;
    std::vector<Pair> touching;
    std::vector<S> slowest;
    for (const Pair& pair : pairs_) {
      const Gap<S> now = gap(scene_, dynamics_.layout(), pair, y);
      if (now.gap_m > tiny(pair, y)) continue;
      touching.push_back(pair);
      slowest.push_back(slow(pair));
      if (now.rate_m_per_s < -slow(pair)) {
        if (!may_strike(pair, t, y)) return made;
        changed = true;
        if (t > 0) made.off_m = std::max(made.off_m, magnitude(now.gap_m));
      }
    }
    if (changed) {
      advances(t);
      dynamics::Resolved<S> resolved = dynamics::strike_all(scene_, dynamics_.layout(), touching, slowest, y);
      if (!resolved.why.empty()) {
        failure_ = "the outcome of simultaneous impacts " + resolved.why;
        branch_ = true;
        return made;
      }
      for (std::size_t k = 0; k < resolved.blows.size(); ++k)
        tell(resolved.blows[k], k + 1 < resolved.blows.size() ? resolved.blows[k + 1].before.data() : y, t, events);
      for (auto& blow : resolved.blows) made.blows.push_back(std::move(blow));
      see_speeds(y);
    }
    for (const Pair& pair : touching) {
      if (!failure_.empty()) break;
      if (gap(scene_, dynamics_.layout(), pair, y).gap_m > tiny(pair, y)) continue;
      if (auto laid = rests(pair, t, y, interval, events)) {
        held_.push_back(pair);
        std::erase_if(pairs_, [&](const Pair& each) { return each.a == pair.a && each.b == pair.b; });
        made.laid.push_back(std::move(*laid));
        changed = true;
      }
    }
  }
  made.after.assign(y, y + dynamics_.size());
  return made;
}

template <class S> void Impacts<S>::check_held(const S* y) {
  for (const Pair& pair : held_)
    if (gap(scene_, dynamics_.layout(), pair, y).gap_m > 1e18 * tiny(pair, y))
      failure_ = "`" + scene_.bodies[dynamics::ball_of(scene_, pair)].name +
                 "` leaves the plane it rests on: not covered by the extended truth";
}

// g(high) < 0, g > 0 before the root. Newton from the parabola through g(0), g'(0), g(high); a step that leaves the
// bracket is replaced by its middle.
template <class S>
S Impacts<S>::locate(const Pair& pair, const S* before, S high, S gap_high, const Again& again) const {
  const Gap<S> start = gap(scene_, dynamics_.layout(), pair, before);
  S low = 0;
  const S bend = (gap_high - start.gap_m - start.rate_m_per_s * high) / (high * high);
  const S inside = start.rate_m_per_s * start.rate_m_per_s - 4 * bend * start.gap_m;
  // The larger root of a falling parabola; without cancellation when the ball is only falling (rate < 0).
  S tau = high;
  if (inside > 0) {
    const S root = dynamics::sqrt(inside);
    tau = start.rate_m_per_s < 0 ? 2 * start.gap_m / (root - start.rate_m_per_s)
                                 : -(start.rate_m_per_s + root) / (2 * bend);
  }
  const S enough = tiny(pair, before) * S(is_wide<S> ? 1e-5 : 1e-2);
  for (int tries = 0; tries < 100; ++tries) {
    if (!(tau > low && tau <= high)) tau = low + (high - low) / 2;
    const std::vector<S> state = again(tau);
    const Gap<S> now = gap(scene_, dynamics_.layout(), pair, state.data());
    if (magnitude(now.gap_m) <= enough || high - low <= enough * S(1e-3) * high) return tau;
    if (now.gap_m > 0) low = tau;
    else high = tau;
    tau = now.rate_m_per_s < 0 ? tau - now.gap_m / now.rate_m_per_s : S(-1);
  }
  return tau;
}

template <class S>
std::optional<S> Impacts<S>::touch(const Pair& pair, const S* before, const S* after, S taken,
                                   const Again& again) const {
  const Gap<S> first = gap(scene_, dynamics_.layout(), pair, before);
  const Gap<S> last = gap(scene_, dynamics_.layout(), pair, after);
  const S round_off = std::max(tiny(pair, before), tiny(pair, after));
  if (last.gap_m < -round_off && (last.rate_m_per_s < 0 || first.gap_m >= -round_off))
    return locate(pair, before, taken, last.gap_m, again);
  const std::optional<Passage> passage = nearest(pair, before, after, taken, again);
  if (!passage) return std::nullopt;
  const Gap<S> least = gap(scene_, dynamics_.layout(), pair, passage->y.data());
  if (least.gap_m >= -round_off) return std::nullopt;
  return locate(pair, before, passage->tau, least.gap_m, again);
}

// The root of the gap's rate, from below to above, by bisection; it ends early at an overlap, and where the gap cannot
// close in what is left of the bracket, as fast as it moves.
template <class S>
std::optional<typename Impacts<S>::Passage> Impacts<S>::nearest(const Pair& pair, const S* before, const S* after,
                                                                S taken, const Again& again) const {
  const Gap<S> first = gap(scene_, dynamics_.layout(), pair, before);
  const Gap<S> last = gap(scene_, dynamics_.layout(), pair, after);
  // Where the rate is round-off at the step's begin the pair was there before, or it goes together.
  if (!(first.rate_m_per_s < -slow(pair) && last.rate_m_per_s >= -slow(pair))) return std::nullopt;
  if (last.rate_m_per_s <= slow(pair)) return Passage{taken, pair, std::vector<S>(after, after + dynamics_.size())};
  const S size = reach(scene_, dynamics_.layout(), pair.a, before) + reach(scene_, dynamics_.layout(), pair.b, before);
  const S round_off = S(kGapRoundOff<S>) * size;
  S low = 0, high = taken;
  Passage found;
  found.pair = pair;
  for (int tries = 0; tries < 120; ++tries) {
    found.tau = low + (high - low) / 2;
    found.y = again(found.tau);
    const Gap<S> now = gap(scene_, dynamics_.layout(), pair, found.y.data());
    if (now.gap_m < -round_off) return found;
    const S way = 4 * magnitude(now.rate_m_per_s) * (high - low);
    if (tries > 3 && now.gap_m > way + kNear * size) return std::nullopt;
    if (way <= round_off / 16 || now.gap_m > 64 * way + round_off) return found;
    if (now.rate_m_per_s < 0) low = found.tau;
    else high = found.tau;
  }
  return found;
}

template <class S>
std::optional<S> Impacts<S>::first_touch(const S* before, const S* after, S taken, const Again& again) const {
  std::optional<S> first;
  for (const Pair& pair : pairs_)
    if (const std::optional<S> at = touch(pair, before, after, taken, again); at && (!first || *at < *first))
      first = at;
  return first;
}

template <class S>
std::vector<typename Impacts<S>::Passage> Impacts<S>::passages(const S* before, const S* after, S taken, S until,
                                                               const Again& again) const {
  std::vector<Passage> made;
  for (const Pair& pair : pairs_)
    if (std::optional<Passage> at = nearest(pair, before, after, taken, again); at && at->tau <= until)
      made.push_back(std::move(*at));
  std::sort(made.begin(), made.end(), [](const Passage& a, const Passage& b) { return a.tau < b.tau; });
  return made;
}

template class Impacts<double>;
template class Impacts<Wide>;

}  // namespace atwood::extended
