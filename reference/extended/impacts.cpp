#include "extended/impacts.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "dynamics/arithmetic.hpp"

namespace atwood::extended {

using dynamics::Gap;
using dynamics::gap;
using dynamics::magnitude;
using dynamics::Triple;
using dynamics::operator+=, dynamics::operator-=, dynamics::operator-, dynamics::operator*;

namespace {

template <class S>
constexpr bool is_wide = std::is_same_v<S, Wide>;
template <class S>
constexpr double gap_round_off = is_wide<S> ? 1e-27 : 1e-11;  // of the scene's size
// Flights shorter than this part of the run are summed as a geometric series. What the series leaves out is the change
// of the pull during the rest of the bounces: of the order of the flight, times a height of the order of its square.
template <class S>
constexpr double last_flight = is_wide<S> ? 1e-10 : 1e-4;
constexpr int most_strikes = 20000;

double scene_size(const Scene& scene) {
  double size = 1e-3;
  for (const Body& body : scene.bodies) {
    if (const auto* sphere = std::get_if<Sphere>(&body.shape)) size = std::max(size, sphere->radius_m);
    if (!body.fixed)
      for (const double x : body.position_m) size = std::max(size, std::fabs(x));
  }
  return size;
}

template <class S>
Event event_at(S t, EventKind kind, const dynamics::ContactPair& pair, const Gap<S>& where) {
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
    : scene_(scene), dynamics_(dynamics), narrow_(narrow), t_end_s_(t_end_s) {
  const dynamics::ContactPairs found = dynamics::contact_pairs(scene);
  pairs_ = found.pairs;
  if (!found.unsupported.empty()) failure_ = found.unsupported + " is not covered by the extended truth";
  for (const Pair& pair : pairs_)
    if (pair.gives)
      failure_ = "the contact of `" + scene.bodies[pair.a].name + "` and `" + scene.bodies[pair.b].name +
                 "`, which gives way, is not covered by the extended truth";
  tiny_ = gap_round_off<S> * scene_size(scene);
}

template <class S>
void Impacts<S>::strike_pair(const Pair& pair, S t, S* y, std::vector<Event>& events) {
  const auto name = [&](int body) { return "`" + scene_.bodies[body].name + "`"; };
  const Gap<S> before = gap(scene_, dynamics_.layout(), pair, y);
  for (const int body : {pair.a, pair.b})
    if (!scene_.bodies[body].fixed && scene_.bodies[body].release_s > t)
      failure_ = name(body) + " is struck before its release: not covered by the extended truth";
  for (const Pair& other : held_)
    for (const int body : {pair.a, pair.b})
      if (body == dynamics::ball_of(scene_, other))
        failure_ = name(body) + " is struck while it rests: not covered by the extended truth";
  if (const std::string why = dynamics::unstrikable(scene_, pair); !why.empty())
    failure_ = why + " is not covered by the extended truth";
  if (++strikes_ > most_strikes) failure_ = "more than " + std::to_string(most_strikes) + " impacts";
  const dynamics::Strike<S> impulse = dynamics::strike(scene_, dynamics_.layout(), pair, y);
  Event made = event_at(t, EventKind::impact, pair, before);
  made.impulse_n_N_s = impulse.normal_N_s;
  made.impulse_t_N_s = impulse.tangential_N_s;
  made.vn_before_m_per_s = before.rate_m_per_s;
  made.vn_after_m_per_s = gap(scene_, dynamics_.layout(), pair, y).rate_m_per_s;
  events.push_back(made);
}

// A ball that leaves a plane at speed v against a pull a flies 2 v / a; all flights to come take
//   sum_k 2 v e^k / a = 2 v / (a (1 - e)).
template <class S>
bool Impacts<S>::rests(const Pair& pair, S t, S* y, int interval, std::vector<Event>& events) {
  const int ball = dynamics::ball_of(scene_, pair);
  const Gap<S> now = gap(scene_, dynamics_.layout(), pair, y);
  std::vector<S> dydt(dynamics_.size());
  dynamics_.rate(t, y, dydt.data(), interval);
  Triple<S> approach{};
  for (const int body : {pair.a, pair.b}) {
    const int at = dynamics_.layout().slots[body].velocity;
    if (at < 0) continue;
    if (body == pair.a) approach -= dynamics::read3(&dydt[at]); else approach += dynamics::read3(&dydt[at]);
  }
  const S pull = -dynamics::dot(approach, now.normal);
  const S speed = magnitude(now.rate_m_per_s);
  const bool lies = speed <= tiny_;  // already, and at any restitution
  if (!(pull > 0) || (pair.restitution >= 1 && !lies)) return false;
  if (2 * speed / pull > last_flight<S> * t_end_s_) return false;
  if (ball < 0) {
    failure_ = "`" + scene_.bodies[pair.a].name + "` and `" + scene_.bodies[pair.b].name +
               "` come to rest on each other: not covered by the extended truth";
    return false;
  }
  if (dynamics::rubs(scene_, dynamics_.layout(), pair, y, dydt.data(), tiny_)) {
    failure_ =
        "`" + scene_.bodies[ball].name +
        "` comes to rest on a plane with friction, and slides or is pulled along: not covered by the extended truth";
    return false;
  }
  const S rest_t = lies ? t : t + 2 * speed / (pull * (1 - S(pair.restitution)));
  const int at = dynamics_.layout().slots[ball].velocity;
  const S outward = ball == pair.b ? now.rate_m_per_s : -now.rate_m_per_s;
  for (int k = 0; k < 3; ++k) y[at + k] -= outward * now.normal[k];
  const Real3& normal = std::get<Plane>(scene_.bodies[ball == pair.b ? pair.a : pair.b].shape).normal;
  dynamics_.hold_on_plane(ball, normal);
  narrow_.hold_on_plane(ball, normal);
  if (rest_t <= t_end_s_ && (t > 0 || speed > 0)) events.push_back(event_at(rest_t, EventKind::rest, pair, now));
  return true;
}

template <class S>
void Impacts<S>::settle(S t, S* y, int interval, std::vector<Event>& events) {
  if (t == 0)
    for (const Pair& pair : pairs_)
      if (gap(scene_, dynamics_.layout(), pair, y).gap_m < -1e-9 * scene_size(scene_))
        failure_ = "`" + scene_.bodies[pair.a].name + "` and `" + scene_.bodies[pair.b].name + "` overlap at the start";
  for (bool changed = true; changed && failure_.empty();) {
    changed = false;
    for (std::size_t k = 0; k < pairs_.size() && failure_.empty(); ++k) {
      const Pair pair = pairs_[k];
      const Gap<S> now = gap(scene_, dynamics_.layout(), pair, y);
      if (now.gap_m > tiny_) continue;
      const bool approaches = now.rate_m_per_s < -tiny_;
      if (approaches) {
        strike_pair(pair, t, y, events);
        changed = true;
      }
      if (rests(pair, t, y, interval, events)) {
        held_.push_back(pair);
        pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(k));
        changed = true;
        break;
      }
    }
  }
}

template <class S>
void Impacts<S>::check_held(const S* y) {
  for (const Pair& pair : held_)
    if (gap(scene_, dynamics_.layout(), pair, y).gap_m > 1e-9 * scene_size(scene_))
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
    const S root = dynamics::root(inside);
    tau = start.rate_m_per_s < 0 ? 2 * start.gap_m / (root - start.rate_m_per_s)
                                 : -(start.rate_m_per_s + root) / (2 * bend);
  }
  const S enough = tiny_ * S(is_wide<S> ? 1e-4 : 1e-2);
  for (int tries = 0; tries < 100; ++tries) {
    if (!(tau > low && tau <= high)) tau = low + (high - low) / 2;
    const std::vector<S> state = again(tau);
    const Gap<S> now = gap(scene_, dynamics_.layout(), pair, state.data());
    if (magnitude(now.gap_m) <= enough || high - low <= enough * S(1e-3) * high) return tau;
    if (now.gap_m > 0) low = tau; else high = tau;
    tau = now.rate_m_per_s < 0 ? tau - now.gap_m / now.rate_m_per_s : S(-1);
  }
  return tau;
}

template <class S>
std::optional<S> Impacts<S>::touch(const Pair& pair, const S* before, const S* after, S taken,
                                   const Again& again) const {
  const Gap<S> first = gap(scene_, dynamics_.layout(), pair, before);
  const Gap<S> last = gap(scene_, dynamics_.layout(), pair, after);
  if (last.gap_m < -tiny_ && (last.rate_m_per_s < 0 || first.gap_m >= -tiny_))
    return locate(pair, before, taken, last.gap_m, again);
  if (!(first.rate_m_per_s < 0 && last.rate_m_per_s > 0)) return std::nullopt;
  // It came nearer and went away again within the step: how near?
  S low = 0, high = taken;
  for (int tries = 0; tries < 60; ++tries) {
    const S middle = low + (high - low) / 2;
    const std::vector<S> state = again(middle);
    const Gap<S> now = gap(scene_, dynamics_.layout(), pair, state.data());
    if (now.gap_m < -tiny_) return locate(pair, before, middle, now.gap_m, again);
    // Nearer than this it cannot come in what is left of the bracket, as fast as it moves.
    if (now.gap_m > 4 * magnitude(now.rate_m_per_s) * (high - low) + tiny_ && tries > 3) return std::nullopt;
    if (now.rate_m_per_s < 0) low = middle; else high = middle;
  }
  return std::nullopt;
}

template <class S>
std::optional<S> Impacts<S>::first_touch(const S* before, const S* after, S taken, const Again& again) const {
  std::optional<S> first;
  for (const Pair& pair : pairs_)
    if (const std::optional<S> at = touch(pair, before, after, taken, again); at && (!first || *at < *first))
      first = at;
  return first;
}

template class Impacts<double>;
template class Impacts<Wide>;

}  // namespace atwood::extended
