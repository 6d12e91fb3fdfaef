#include "cvode/contacts.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/arithmetic.hpp"
#include "dynamics/last_bounces.hpp"

namespace atwood::cvode {

using dynamics::ContactPair;
using dynamics::Gap;
using dynamics::gap;
using dynamics::Triple;

namespace {

// A gap that the location of a root leaves: CVODE stops within 100 units in the last place of the time.
constexpr double kTouching = 1e-10;         // of the scene's size
constexpr double kStartRoundOff = 0x1p-46;  // of the scene's size: gaps of bodies placed in contact
// Bounces lower than this many times the error that CVODE may make in a position (rtol x + atol) are not followed: they
// are summed as a geometric series. Followed further, the ball would meet the plane at the integrator's errors.
constexpr double kLowestBounce = 100;
constexpr double kLowestBounceCap = 1e-4;  // of the scene's size, for coarse tolerances

// What a few sums and products of its terms leave of a value that should be zero.
constexpr double kRoundOff = 16 * 0x1p-52;
constexpr double kPassing = 1e-9;     // of the speeds: a gap's rate at the root that was located
constexpr double kOverlooked = 1e-7;  // of the scene's size: an overlap that no root has shown

// Impacts in a row during which the time advances by less than a unit in its last place: there is no progress.
constexpr int kMostStalled = 1000;

double length(const Triple<double>& v) { return std::sqrt(dynamics::dot(v, v)); }

double scene_size(const Scene& scene) {
  double size = 0;
  for (const Body& body : scene.bodies) {
    if (const auto* sphere = std::get_if<Sphere>(&body.shape)) size = std::max(size, sphere->radius_m);
    if (!body.fixed)
      for (const double x : body.position_m) size = std::max(size, std::fabs(x));
  }
  return size > 0 ? size : 1;
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
      low_bounce_m_(std::min(kLowestBounce * (options.rtol * size_m_ + options.atol * options.scales.position_m),
                             kLowestBounceCap * size_m_)),
      rtol_(options.rtol), atol_m_per_s_(options.atol * options.scales.velocity_m_per_s) {
  const dynamics::ContactPairs found = dynamics::contact_pairs(scene);
  for (const ContactPair& pair : found.pairs)
    if (!pair.gives) pairs_.push_back({pair});  // else giving_contacts.hpp
  if (!found.unsupported.empty()) failure_ = "CVODE: " + found.unsupported + " is not covered";
  const std::vector<double> y = dynamics::pack<double>(scene);
  for (const ContactPair& pair : pairs_) {
    const double apart_m = gap(scene_, equations_.layout(), pair, y.data()).gap_m;
    const std::string both = name(pair.a) + " and " + name(pair.b);
    if (apart_m < -kTouching * size_m_) failure_ = "CVODE: " + both + " overlap at the start";
    // What lies between the round-off of a contact and `touching` would be taken for one.
    if (apart_m > kStartRoundOff * size_m_ && apart_m <= kTouching * size_m_)
      failure_ = "CVODE: " + both + " start " + format_double(apart_m) + " m apart, too near to be told from a contact";
  }
}

void Contacts::evaluate(const double* y, double* g) const {
  const double near = kTouching * size_m_;
  for (const Pair& pair : pairs_) {
    const Gap<double> now = gap(scene_, equations_.layout(), pair, y);
    *g++ = pair.together ? now.gap_m + near : now.gap_m;
    *g++ = pair.together ? 2 * near - now.gap_m : -now.rate_m_per_s;
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
  return pair.together && gap_m > -kTouching / 2 * size_m_ ? rtol_ * speeds + atol_m_per_s_ : kRoundOff * speeds;
}

// May the pair be struck at all? Fills failure() if not.
bool Contacts::may_strike(const ContactPair& pair, double t_s, const std::vector<double>& y) {
  for (const int body : {pair.a, pair.b})
    if (!scene_.bodies[body].fixed && scene_.bodies[body].release_s > t_s)
      failure_ = "CVODE: " + name(body) + " is struck before its release: not covered";
  for (const ContactPair& held : held_)
    for (const int body : {pair.a, pair.b})
      if (!scene_.bodies[body].fixed && (body == held.a || body == held.b) &&
          dynamics::couple(scene_, equations_.layout(), pair, held, y.data())) {
        failure_ = "CVODE: " + name(body) + " is struck while it rests: not covered";
        branch_ = true;
      }
  if (const std::string why = dynamics::unstrikable(scene_, pair); !why.empty())
    failure_ = "CVODE: " + why + " is not covered";
  return failure_.empty();
}

void Contacts::tell(const dynamics::Blow<double>& blow, const double* after, double t_s,
                    std::vector<Event>& events) const {
  for (std::size_t k = 0; k < blow.pairs.size(); ++k) {
    if (!(blow.impulses[k].normal_N_s > 0)) continue;
    const Gap<double> before = gap(scene_, equations_.layout(), blow.pairs[k], blow.before.data());
    Event made = event_at(t_s, EventKind::impact, blow.pairs[k], before);
    made.impulse_n_N_s = blow.impulses[k].normal_N_s;
    made.impulse_t_N_s = blow.impulses[k].tangential_N_s;
    made.vn_before_m_per_s = before.rate_m_per_s;
    made.vn_after_m_per_s = gap(scene_, equations_.layout(), blow.pairs[k], after).rate_m_per_s;
    events.push_back(made);
  }
}

// Counts impacts, not their number but whether the time advances.
void Contacts::advances(double t_s) {
  stalled_ = last_strike_s_ >= 0 && t_s - last_strike_s_ <= 0x1p-52 * t_s ? stalled_ + 1 : 0;
  last_strike_s_ = t_s;
  if (stalled_ > kMostStalled)
    failure_ = "CVODE: the time does not advance over " + std::to_string(kMostStalled) +
               " impacts at t = " + format_double(t_s) + " s";
}

// A ball whose next bounce is lower than `low_bounce_m_` is laid to rest.
bool Contacts::rests(const Pair& pair, double t_s, std::vector<double>& y, int interval, std::vector<Event>& events,
                     dynamics::Instant<double>& told) {
  const Gap<double> now = gap(scene_, equations_.layout(), pair, y.data());
  const double speed = std::fabs(now.rate_m_per_s);
  const dynamics::LastBounces<double> last = dynamics::last_bounces(
      scene_, equations_, static_cast<const ContactPair&>(pair), t_s, y.data(), interval, pair.together ? speed : -1);
  double pull = 0, pulls = 0;
  for (const int body : {pair.a, pair.b}) {
    const int at = equations_.layout().slots[body].velocity;
    if (at < 0) continue;
    pull += (body == pair.a ? 1 : -1) * dynamics::dot(dynamics::read3(&last.dydt[at]), now.normal);
    pulls += length(dynamics::read3(&last.dydt[at]));
  }
  if (!(pull > (pair.together ? rtol_ : kRoundOff) * pulls)) return false;
  if ((pair.restitution >= 1 && !pair.together) || speed * speed > 2 * pull * low_bounce_m_) return false;
  const int ball = dynamics::ball_of(scene_, pair);
  if (ball < 0) {
    failure_ = "CVODE: " + name(pair.a) + " and " + name(pair.b) + " come to rest on each other: not covered";
    return false;
  }
  if (dynamics::rubs(scene_, equations_.layout(), pair, y.data(), last.dydt.data(),
                     1e-8 * speed + rtol_ * length(dynamics::read3(&y[equations_.layout().slots[ball].velocity])) +
                         1e3 * atol_m_per_s_)) {
    failure_ =
        "CVODE: " + name(ball) + " comes to rest on a plane with friction, and slides or is pulled along: not covered";
    return false;
  }
  if (!last.ends) {
    failure_ = "CVODE: when " + name(ball) + " comes to rest is not decided: its restitution is too near 1";
    return false;
  }
  dynamics::Laid<double> laid = last.laid;
  laid.told = t_s > 0 || speed > 0;
  y = last.held;
  equations_.hold_on_plane(ball, laid.normal);
  if (laid.told) events.push_back(event_at(laid.until, EventKind::rest, pair, now));
  told.laid.push_back(std::move(laid));
  return true;
}

bool Contacts::settle(double t_s, std::vector<double>& y, int interval, std::vector<Event>& events,
                      dynamics::Instant<double>& told) {
  told.t = t_s;
  told.interval = interval;
  told.first_event = events.size();
  bool ever = false;
  for (bool changed = true; changed && failure_.empty();) {
    changed = false;
    std::vector<ContactPair> meeting;
    std::vector<double> slowest;
    for (const Pair& pair : pairs_) {
      const Gap<double> now = gap(scene_, equations_.layout(), pair, y.data());
      if (now.gap_m > kTouching * size_m_) continue;
      meeting.push_back(pair);
      slowest.push_back(slow(pair, now.gap_m, y));
      if (!(now.rate_m_per_s < -slowest.back())) continue;
      if (!may_strike(pair, t_s, y)) return ever;
      changed = ever = true;
      if (t_s > 0) told.off_m = std::max(told.off_m, std::fabs(now.gap_m));
    }
    if (changed) {
      advances(t_s);
      auto resolved = dynamics::strike_all(scene_, equations_.layout(), meeting, slowest, y.data());
      if (!resolved.why.empty()) {
        failure_ = "CVODE: the outcome of simultaneous impacts " + resolved.why;
        branch_ = true;
        return ever;
      }
      for (std::size_t k = 0; k < resolved.blows.size(); ++k)
        tell(resolved.blows[k], k + 1 < resolved.blows.size() ? resolved.blows[k + 1].before.data() : y.data(), t_s,
             events);
      for (auto& blow : resolved.blows) told.blows.push_back(std::move(blow));
    }
    for (std::size_t k = 0; k < pairs_.size() && failure_.empty(); ++k) {
      Pair& pair = pairs_[k];
      const Gap<double> now = gap(scene_, equations_.layout(), pair, y.data());
      const bool near = now.gap_m <= kTouching * size_m_;
      const bool together = near && std::fabs(now.rate_m_per_s) <= slow(pair, now.gap_m, y);
      ever |= together != pair.together;
      pair.together = together;
      if (!near || !rests(pair, t_s, y, interval, events, told)) continue;
      held_.push_back(pair);
      pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(k));
      changed = ever = true;
      break;
    }
  }
  told.after = y;
  return ever;
}

std::vector<ContactPair> Contacts::passed(const std::vector<double>& y) const {
  std::vector<ContactPair> made;
  for (const Pair& pair : pairs_) {
    double speeds = 0;
    for (const int body : {pair.a, pair.b})
      if (const int at = equations_.layout().slots[body].velocity; at >= 0) speeds += length(dynamics::read3(&y[at]));
    const Gap<double> now = gap(scene_, equations_.layout(), pair, y.data());
    if (!pair.together && std::fabs(now.rate_m_per_s) <= kPassing * speeds) made.push_back(pair);
  }
  return made;
}

void Contacts::check(const std::vector<double>& y) {
  for (const Pair& pair : pairs_)
    if (gap(scene_, equations_.layout(), pair, y.data()).gap_m < -kOverlooked * size_m_)
      failure_ = "CVODE: " + name(pair.a) + " and " + name(pair.b) +
                 " press on each other and got into each other: not covered";
  for (const ContactPair& pair : held_)
    if (gap(scene_, equations_.layout(), pair, y.data()).gap_m > 1e-6 * size_m_)
      failure_ = "CVODE: " + name(dynamics::ball_of(scene_, pair)) + " leaves the plane it rests on: not covered";
}

}  // namespace atwood::cvode
