#include "cvode/contacts.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/arithmetic.hpp"

namespace atwood::cvode {

using dynamics::ContactPair;
using dynamics::Gap;
using dynamics::gap;
using dynamics::Triple;
using dynamics::operator+=, dynamics::operator-=, dynamics::operator-, dynamics::operator*;

namespace {

// A gap that the location of a root leaves: CVODE stops within 100 units in the last place of the time.
constexpr double touching = 1e-10;  // of the scene's size
// Bounces lower than this many times the error that CVODE may make in a position (rtol x + atol) are not followed: they
// are summed as a geometric series. Followed further, the ball would meet the plane at the integrator's errors.
constexpr double lowest_bounce = 100;
constexpr double lowest_bounce_cap = 1e-4;  // of the scene's size, for coarse tolerances

// What a few sums and products of its terms leave of a value that should be zero.
constexpr double round_off = 16 * 0x1p-52;
constexpr double overlooked = 1e-7;  // of the scene's size: an overlap that no root has shown

constexpr int most_strikes = 2000;

double length(const Triple<double>& v) { return std::sqrt(dynamics::dot(v, v)); }

double scene_size(const Scene& scene) {
  double size = 1e-3;
  for (const Body& body : scene.bodies) {
    if (const auto* sphere = std::get_if<Sphere>(&body.shape)) size = std::max(size, sphere->radius_m);
    if (!body.fixed)
      for (const double x : body.position_m) size = std::max(size, std::fabs(x));
  }
  return size;
}

Event event_at(double t_s, EventKind kind, const ContactPair& pair, const Gap<double>& where) {
  Event made;
  made.t_s = t_s;
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

Contacts::Contacts(const Scene& scene, dynamics::Dynamics<double>& equations, const Options& options)
    : scene_(scene), equations_(equations), size_m_(scene_size(scene)),
      low_bounce_m_(std::min(lowest_bounce * (options.rtol * size_m_ + options.atol), lowest_bounce_cap * size_m_)),
      rtol_(options.rtol), atol_(options.atol) {
  const dynamics::ContactPairs found = dynamics::contact_pairs(scene);
  for (const ContactPair& pair : found.pairs)
    if (!pair.gives) pairs_.push_back({pair});  // else giving_contacts.hpp
  if (!found.unsupported.empty()) failure_ = "CVODE: " + found.unsupported + " is not covered";
  const std::vector<double> y = dynamics::pack<double>(scene);
  for (const ContactPair& pair : pairs_)
    if (gap(scene_, equations_.layout(), pair, y.data()).gap_m < -touching * size_m_)
      failure_ = "CVODE: " + name(pair.a) + " and " + name(pair.b) + " overlap at the start";
}

void Contacts::evaluate(const double* y, double* g) const {
  const double near = touching * size_m_;
  for (const Pair& pair : pairs_) {
    const Gap<double> now = gap(scene_, equations_.layout(), pair, y);
    *g++ = pair.together ? now.gap_m + near : now.gap_m;
    *g++ = pair.together ? 2 * near - now.gap_m : dynamics::plane_of(scene_, pair) < 0 ? -now.rate_m_per_s : 1;
  }
}

// The speed below which two bodies that touch neither approach nor leave: round-off of their velocities, and for those
// that are together and do not overlap yet the solver's error in them.
double Contacts::slow(const Pair& pair, double gap_m, const std::vector<double>& y) const {
  double speeds = 0;
  for (const int body : {pair.a, pair.b}) {
    const int at = equations_.layout().slots[body].velocity;
    if (at >= 0) speeds += length(dynamics::read3(&y[at]));
  }
  return pair.together && gap_m > -touching / 2 * size_m_ ? rtol_ * speeds + atol_ : round_off * speeds;
}

void Contacts::strike(const ContactPair& pair, double t_s, std::vector<double>& y, std::vector<Event>& events) {
  const Gap<double> before = gap(scene_, equations_.layout(), pair, y.data());
  for (const int body : {pair.a, pair.b})
    if (!scene_.bodies[body].fixed && scene_.bodies[body].release_s > t_s)
      failure_ = "CVODE: " + name(body) + " is struck before its release: not covered";
  for (const ContactPair& held : held_)
    for (const int body : {pair.a, pair.b})
      if (!scene_.bodies[body].fixed && (body == held.a || body == held.b))
        failure_ = "CVODE: " + name(body) + " is struck while it rests: not covered";
  if (const std::string why = dynamics::unstrikable(scene_, pair); !why.empty())
    failure_ = "CVODE: " + why + " is not covered";
  if (++strikes_ > most_strikes) failure_ = "CVODE: more than " + std::to_string(most_strikes) + " impacts";
  const dynamics::Strike<double> impulse = dynamics::strike(scene_, equations_.layout(), pair, y.data());
  Event made = event_at(t_s, EventKind::impact, pair, before);
  made.impulse_n_N_s = impulse.normal_N_s;
  made.impulse_t_N_s = impulse.tangential_N_s;
  made.vn_before_m_per_s = before.rate_m_per_s;
  made.vn_after_m_per_s = gap(scene_, equations_.layout(), pair, y.data()).rate_m_per_s;
  events.push_back(made);
}

// A ball that leaves a plane at speed v against a pull a flies 2 v / a; all flights to come take 2 v / (a (1 - e)).
bool Contacts::rests(const Pair& pair, double t_s, std::vector<double>& y, int interval,
                     std::vector<Event>& events) {
  const Gap<double> now = gap(scene_, equations_.layout(), pair, y.data());
  std::vector<double> dydt(y.size());
  equations_.rate(t_s, y.data(), dydt.data(), interval);
  double pull = 0, pulls = 0;
  for (const int body : {pair.a, pair.b}) {
    const int at = equations_.layout().slots[body].velocity;
    if (at < 0) continue;
    pull += (body == pair.a ? 1 : -1) * dynamics::dot(dynamics::read3(&dydt[at]), now.normal);
    pulls += length(dynamics::read3(&dydt[at]));
  }
  if (!(pull > (pair.together ? rtol_ : round_off) * pulls)) return false;
  const double speed = std::fabs(now.rate_m_per_s), flight = 2 * speed / pull;
  if ((pair.restitution >= 1 && !pair.together) || speed * speed > 2 * pull * low_bounce_m_) return false;
  const int plane = dynamics::plane_of(scene_, pair), ball = dynamics::ball_of(scene_, pair);
  if (plane < 0) {
    failure_ = "CVODE: " + name(pair.a) + " and " + name(pair.b) + " come to rest on each other: not covered";
    return false;
  }
  if (dynamics::rubs(scene_, equations_.layout(), pair, y.data(), dydt.data(), 1e-8 * speed + 1e-9)) {
    failure_ =
        "CVODE: " + name(ball) + " comes to rest on a plane with friction, and slides or is pulled along: not covered";
    return false;
  }
  const int at = equations_.layout().slots[ball].velocity;
  const double rest_s = pair.together ? t_s : t_s + flight / (1 - pair.restitution);
  const double outward = ball == pair.b ? now.rate_m_per_s : -now.rate_m_per_s;
  for (int k = 0; k < 3; ++k) y[at + k] -= outward * now.normal[k];
  equations_.hold_on_plane(ball, std::get<Plane>(scene_.bodies[plane].shape).normal);
  if (t_s > 0 || speed > 0) events.push_back(event_at(rest_s, EventKind::rest, pair, now));
  return true;
}

bool Contacts::settle(double t_s, std::vector<double>& y, int interval, std::vector<Event>& events) {
  bool ever = false;
  for (bool changed = true; changed && failure_.empty();) {
    changed = false;
    for (std::size_t k = 0; k < pairs_.size() && failure_.empty(); ++k) {
      Pair& pair = pairs_[k];
      Gap<double> now = gap(scene_, equations_.layout(), pair, y.data());
      const bool near = now.gap_m <= touching * size_m_;
      if (near && now.rate_m_per_s < -slow(pair, now.gap_m, y)) {
        strike(pair, t_s, y, events);
        changed = ever = true;
        now = gap(scene_, equations_.layout(), pair, y.data());
      }
      const bool together = near && std::fabs(now.rate_m_per_s) <= slow(pair, now.gap_m, y);
      ever |= together != pair.together;
      pair.together = together;
      if (!near) continue;
      if (failure_.empty() && rests(pair, t_s, y, interval, events)) {
        held_.push_back(pair);
        pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(k));
        changed = ever = true;
        break;
      }
    }
  }
  return ever;
}

void Contacts::check(const std::vector<double>& y) {
  for (const Pair& pair : pairs_)
    if (gap(scene_, equations_.layout(), pair, y.data()).gap_m < -overlooked * size_m_)
      failure_ = "CVODE: " + name(pair.a) + " and " + name(pair.b) +
                 " press on each other and got into each other: not covered";
  for (const ContactPair& pair : held_)
    if (gap(scene_, equations_.layout(), pair, y.data()).gap_m > 1e-6 * size_m_)
      failure_ = "CVODE: " + name(dynamics::ball_of(scene_, pair)) + " leaves the plane it rests on: not covered";
}

}  // namespace atwood::cvode
