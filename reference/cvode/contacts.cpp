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

// The gap at a located root: CVODE locates the time to within 100 units in its last place.
constexpr double kContactTolerance = 1e-10;  // of the scene's size
constexpr double kStartRoundOff = 0x1p-46;   // of the scene's size: gaps of bodies that the scene places in contact
// Bounces lower than this many times the tolerance of a position (rtol x + atol) are summed as a geometric series: the
// impacts of lower ones would be located within the integration's error.
constexpr double kMinBounceInTolerances = 100;
constexpr double kMinBounceCap = 1e-4;  // of the scene's size, for coarse tolerances

// Relative round-off of a sum of a few products.
constexpr double kRoundOff = 16 * 0x1p-52;
constexpr double kClosestApproachRate = 1e-9;  // of the scene's speeds: rate of the gap at a located closest approach
constexpr double kMissedOverlap = 1e-7;        // of the scene's size: an overlap that no root has found

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

}  // namespace

Contacts::Contacts(const Scene& scene, dynamics::Dynamics<double>& equations, const Options& options)
    : scene_(scene), equations_(equations), size_m_(scene_size(scene)),
      low_bounce_m_(
          std::min(kMinBounceInTolerances * (options.rtol * size_m_ + options.atol * options.scales.position_m),
                   kMinBounceCap * size_m_)),
      rtol_(options.rtol), speed_m_per_s_(options.scales.velocity_m_per_s),
      atol_m_per_s_(options.atol * options.scales.velocity_m_per_s) {
  const dynamics::ContactPairs found = dynamics::contact_pairs(scene);
  for (const ContactPair& pair : found.pairs)
    if (!pair.compliant) pairs_.push_back({pair});  // else compliant_contacts.hpp
  if (!found.unsupported.empty()) failure_ = "CVODE: " + found.unsupported + " is not covered";
  const std::vector<double> y = dynamics::pack<double>(scene);
  for (const ContactPair& pair : pairs_) {
    const double gap_m = gap(scene_, equations_.layout(), pair, y.data()).gap_m;
    const std::string both = name(pair.a) + " and " + name(pair.b);
    if (gap_m < -kContactTolerance * size_m_) failure_ = "CVODE: " + both + " overlap at the start";
    // A gap between these tolerances would be treated as a contact.
    if (gap_m > kStartRoundOff * size_m_ && gap_m <= kContactTolerance * size_m_)
      failure_ = "CVODE: " + both + " start " + format_double(gap_m) + " m apart: expected a contact (gap 0 to " +
                 format_double(kStartRoundOff * size_m_) + " m) or a gap above " +
                 format_double(kContactTolerance * size_m_) + " m";
  }
}

void Contacts::evaluate(const double* y, double* g) const {
  const double tolerance_m = kContactTolerance * size_m_;
  for (const Pair& pair : pairs_) {
    const Gap<double> now = gap(scene_, equations_.layout(), pair, y);
    *g++ = pair.in_contact ? now.gap_m + tolerance_m : now.gap_m;
    *g++ = pair.in_contact ? 2 * tolerance_m - now.gap_m : -now.rate_m_per_s;
  }
}

// The normal speed below which two bodies that touch neither approach nor separate: round-off of their velocities, or,
// for pairs in contact that do not overlap, the tolerance of their velocities.
double Contacts::speed_tolerance(const Pair& pair, double gap_m, const std::vector<double>& y) const {
  double speeds = 0;
  for (const int body : {pair.a, pair.b}) {
    const int at = equations_.layout().slots[body].velocity;
    if (at >= 0) speeds += length(dynamics::read3(&y[at]));
  }
  return pair.in_contact && gap_m > -kContactTolerance / 2 * size_m_ ? rtol_ * speeds + atol_m_per_s_
                                                                     : kRoundOff * speeds;
}

bool Contacts::bring_to_rest(const Pair& pair, double t_s, std::vector<double>& y, int interval,
                             std::vector<Event>& events, dynamics::Instant<double>& instant) {
  const Gap<double> now = gap(scene_, equations_.layout(), pair, y.data());
  const double speed = std::fabs(now.rate_m_per_s);
  const dynamics::LastBounces<double> last = dynamics::last_bounces(
      scene_, equations_, static_cast<const ContactPair&>(pair), t_s, y.data(), interval, pair.in_contact ? speed : -1);
  double approach_acceleration = 0, accelerations = 0;
  for (const int body : {pair.a, pair.b}) {
    const int at = equations_.layout().slots[body].velocity;
    if (at < 0) continue;
    approach_acceleration += (body == pair.a ? 1 : -1) * dynamics::dot(dynamics::read3(&last.dydt[at]), now.normal);
    accelerations += length(dynamics::read3(&last.dydt[at]));
  }
  if (!(approach_acceleration > (pair.in_contact ? rtol_ : kRoundOff) * accelerations)) return false;
  if ((pair.restitution >= 1 && !pair.in_contact) || speed * speed > 2 * approach_acceleration * low_bounce_m_)
    return false;
  const int ball = dynamics::ball_of(scene_, pair);
  if (ball < 0) {
    failure_ = "CVODE: " + name(pair.a) + " comes to rest on " + name(pair.b) + ", which is not a plane: not covered";
    return false;
  }
  if (dynamics::friction_acts(scene_, equations_.layout(), pair, y.data(), last.dydt.data(),
                              1e-8 * speed +
                                  rtol_ * length(dynamics::read3(&y[equations_.layout().slots[ball].velocity])) +
                                  1e3 * atol_m_per_s_)) {
    failure_ = "CVODE: " + name(ball) +
               " comes to rest on a plane with friction and slides or accelerates along it: not covered";
    return false;
  }
  if (!last.converges) {
    failure_ = "CVODE: the time at which " + name(ball) +
               " comes to rest is not bounded: its restitution is too close to 1 for the change of its acceleration";
    return false;
  }
  dynamics::BounceSeries<double> series = last.series;
  series.has_event = t_s > 0 || speed > 0;
  y = last.y_at_rest;
  equations_.hold_on_plane(ball, series.normal);
  if (series.has_event) events.push_back(dynamics::event_at(series.t_rest, EventKind::rest, pair, now));
  instant.series.push_back(std::move(series));
  return true;
}

bool Contacts::resolve(double t_s, std::vector<double>& y, int interval, std::vector<Event>& events,
                       dynamics::Instant<double>& instant) {
  instant.t = t_s;
  instant.interval = interval;
  instant.first_event = events.size();
  bool any_change = false;
  for (bool changed = true; changed && failure_.empty();) {
    changed = false;
    std::vector<ContactPair> contacts;
    std::vector<double> speed_tolerances;
    for (const Pair& pair : pairs_) {
      const Gap<double> now = gap(scene_, equations_.layout(), pair, y.data());
      if (now.gap_m > kContactTolerance * size_m_) continue;
      contacts.push_back(pair);
      speed_tolerances.push_back(speed_tolerance(pair, now.gap_m, y));
      if (!(now.rate_m_per_s < -speed_tolerances.back())) continue;
      if (const auto refused = dynamics::impact_refusal(scene_, equations_.layout(), pair, held_, t_s, y.data());
          !refused.why.empty()) {
        failure_ = "CVODE: " + refused.why;
        valid_until_failure_ = refused.valid_until_failure;
        return any_change;
      }
      changed = any_change = true;
      if (t_s > 0) instant.gap_error_m = std::max(instant.gap_error_m, std::fabs(now.gap_m));
    }
    if (changed) {
      if (!progress_.advances(t_s)) failure_ = "CVODE: " + progress_.failure(t_s);
      auto outcome = dynamics::resolve_impacts(scene_, equations_.layout(), contacts, speed_tolerances, y.data());
      if (!outcome.why.empty()) {
        failure_ = "CVODE: the outcome of simultaneous impacts " + outcome.why;
        valid_until_failure_ = true;
        return any_change;
      }
      for (std::size_t k = 0; k < outcome.impacts.size(); ++k)
        dynamics::append_impacts(scene_, equations_.layout(), outcome.impacts[k],
                                 k + 1 < outcome.impacts.size() ? outcome.impacts[k + 1].before.data() : y.data(), t_s,
                                 events);
      for (auto& impact : outcome.impacts) instant.impacts.push_back(std::move(impact));
    }
    for (std::size_t k = 0; k < pairs_.size() && failure_.empty(); ++k) {
      Pair& pair = pairs_[k];
      const Gap<double> now = gap(scene_, equations_.layout(), pair, y.data());
      const bool touching = now.gap_m <= kContactTolerance * size_m_;
      const bool in_contact = touching && std::fabs(now.rate_m_per_s) <= speed_tolerance(pair, now.gap_m, y);
      any_change |= in_contact != pair.in_contact;
      pair.in_contact = in_contact;
      if (!touching || !bring_to_rest(pair, t_s, y, interval, events, instant)) continue;
      held_.push_back(pair);
      pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(k));
      changed = any_change = true;
      break;
    }
  }
  instant.after = y;
  return any_change;
}

std::vector<ContactPair> Contacts::closest_approaches(const std::vector<double>& y) const {
  std::vector<ContactPair> made;
  for (const Pair& pair : pairs_) {
    double speeds = speed_m_per_s_;  // bodies may stand still where they are closest
    for (const int body : {pair.a, pair.b})
      if (const int at = equations_.layout().slots[body].velocity; at >= 0) speeds += length(dynamics::read3(&y[at]));
    const Gap<double> now = gap(scene_, equations_.layout(), pair, y.data());
    if (!pair.in_contact && std::fabs(now.rate_m_per_s) <= kClosestApproachRate * speeds) made.push_back(pair);
  }
  return made;
}

void Contacts::check_penetration(double t_s, const std::vector<double>& y) {
  for (const Pair& pair : pairs_)
    if (gap(scene_, equations_.layout(), pair, y.data()).gap_m < -kMissedOverlap * size_m_)
      failure_ = "CVODE: " + name(pair.a) + " and " + name(pair.b) + " overlap at t = " + format_double(t_s) +
                 " s without an impact (a lasting contact): not covered";
  for (const ContactPair& pair : held_)
    if (gap(scene_, equations_.layout(), pair, y.data()).gap_m > 1e-6 * size_m_)
      failure_ = "CVODE: " + name(dynamics::ball_of(scene_, pair)) +
                 " separates from the plane it rests on at t = " + format_double(t_s) + " s: not covered";
}

}  // namespace atwood::cvode
