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

// The gap at a located event.
constexpr double kContactTolerance = 1e-10;  // of the scene's size
constexpr double kStartRoundOff = 0x1p-46;   // of the scene's size: gaps of bodies that the scene places in contact
// Bounces lower than this many times the tolerance of a position (rtol x + atol) are summed as a geometric series: the
// impacts of lower ones would be located within the integration's error.
constexpr double kMinBounceInTolerances = 100;
constexpr double kMinBounceCap = 1e-4;  // of the scene's size, for coarse tolerances

// Relative round-off of a sum of a few products.
constexpr double kRoundOff = 16 * 0x1p-52;
constexpr double kPassage = 1e-3;         // of the scene's size: closest approaches to within it are reported
constexpr double kMissedOverlap = 1e-7;   // of the scene's size: an overlap that no event has begun
constexpr double kDrivePhase = 4;         // rad of a drive that thirteen points resolve
constexpr double kForceRoundOff = 1e-12;  // of the accelerations at rest so far

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

Contacts::Contacts(const Scene& scene, dynamics::Dynamics<double>& equations, const CompliantContacts& compliant,
                   const Options& options)
    : scene_(scene), equations_(equations), compliant_(compliant), size_m_(scene_size(scene)),
      low_bounce_m_(
          std::clamp(kMinBounceInTolerances * (options.rtol * size_m_ + options.atol * options.scales.position_m),
                     kContactTolerance * size_m_, kMinBounceCap * size_m_)),
      rtol_(options.rtol), atol_m_per_s_(options.atol * options.scales.velocity_m_per_s) {
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
  for (const int body : {pair.a, pair.b})
    if (compliant_.presses_on(body) && speed > 0) {
      failure_ = "CVODE: " + name(body) + " comes to rest at t = " + format_double(t_s) +
                 " s while a compliant contact presses on it: not covered";
      valid_until_failure_ = true;
      return false;
    }
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
  hold_ball(pair, series.normal);
  if (series.has_event) events.push_back(dynamics::event_at(series.t_rest, EventKind::rest, pair, now));
  instant.series.push_back(std::move(series));
  return true;
}

void Contacts::resolve(double t_s, std::vector<double>& y, int interval, std::vector<Event>& events,
                       dynamics::Instant<double>& instant) {
  instant.t = t_s;
  instant.interval = interval;
  instant.first_event = events.size();
  if (t_s > 0 && !progress_.advances(t_s)) failure_ = "CVODE: " + progress_.failure(t_s);
  let_go(t_s, y, events, instant);
  const std::vector<ContactPair> held(held_.begin(), held_.end());
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
      if (const auto refused = dynamics::impact_refusal(scene_, equations_.layout(), pair, held, t_s, y.data());
          !refused.why.empty()) {
        failure_ = "CVODE: " + refused.why;
        valid_until_failure_ = refused.valid_until_failure;
        return;
      }
      changed = true;
      if (t_s > 0) instant.gap_error_m = std::max(instant.gap_error_m, std::fabs(now.gap_m));
    }
    if (changed) {
      if (!progress_.advances(t_s)) failure_ = "CVODE: " + progress_.failure(t_s);
      auto outcome = dynamics::resolve_impacts(scene_, equations_.layout(), contacts, speed_tolerances, y.data());
      if (!outcome.why.empty()) {
        failure_ = "CVODE: the outcome of simultaneous impacts " + outcome.why;
        valid_until_failure_ = true;
        return;
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
      pair.in_contact = touching && std::fabs(now.rate_m_per_s) <= speed_tolerance(pair, now.gap_m, y);
      if (!touching || pair.left_s == t_s || !bring_to_rest(pair, t_s, y, interval, events, instant)) continue;
      pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(k));
      changed = true;
      break;
    }
  }
  for (Pair& pair : pairs_) pair.gap = pair.opening = {};
  for (Held& each : held_) each.force = {};
  instant.after = y;
}

// ---- balls at rest on a plane
// ----------------------------------------------------------------------------------------
namespace {

bool acts_on(const Force& force, int body) {
  return std::visit(
      [&](const auto& each) {
        if constexpr (requires { each.bodies; }) return std::count(each.bodies.begin(), each.bodies.end(), body) > 0;
        else if constexpr (requires { each.body; }) return each.body == body;
        else return true;
      },
      force);
}

}  // namespace

void Contacts::hold_ball(const ContactPair& pair, const Real3& normal) {
  Held made{pair};
  const Triple<double> n = dynamics::widen<double>(normal);
  const double inverse = dynamics::rsqrt(dynamics::dot(n, n));
  made.normal = {inverse * n[0], inverse * n[1], inverse * n[2]};
  const int ball = dynamics::ball_of(scene_, pair);
  made.constant = !compliant_.any();
  made.largest = length(scene_.gravity_m_per_s2);
  for (const Force& force : scene_.forces) {
    if (!acts_on(force, ball)) continue;
    made.constant = false;
    if (const auto* drive = std::get_if<Drive>(&force); drive && drive->angular_frequency_rad_per_s != 0)
      made.least_drive_s = std::min(made.least_drive_s, kDrivePhase / std::fabs(drive->angular_frequency_rad_per_s));
  }
  held_.push_back(made);
}

void Contacts::hold(double* dydt) const {
  for (const Held& each : held_) {
    double* a = dydt + equations_.layout().slots[dynamics::ball_of(scene_, each)].velocity;
    const double into = dynamics::dot(dynamics::read3(a), each.normal);
    for (int k = 0; k < 3 && into < 0; ++k) a[k] -= into * each.normal[k];
  }
}

void Contacts::find_lift(Held& held, const Trajectory& path, const Rate& rate, double from_s, double& to_s, bool& any) {
  held.leaves = false;
  if (held.constant) return;
  const int at = equations_.layout().slots[dynamics::ball_of(scene_, held)].velocity;
  std::vector<double> y, dydt(equations_.layout().size);
  const auto pressing = [&](double t_s) {
    path.state(t_s, y);
    rate(t_s, y.data(), dydt.data());
    held.largest = std::max(held.largest, length(dynamics::read3(&dydt[at])));
    return -dynamics::dot(dynamics::read3(&dydt[at]), held.normal);
  };
  pressing(from_s);
  pressing(to_s);
  const Sampled found =
      first_zero_of_samples(pressing, from_s, to_s, held.least_drive_s, kForceRoundOff * held.largest, held.force);
  if (found.open_s) undecided(held, *found.open_s);
  if (!found.zero_s && !found.open_s) return;
  any = true;
  to_s = std::max(from_s, found.zero_s ? *found.zero_s : *found.open_s);
  for (Held& other : held_) other.leaves = other.leaves && &other == &held;
  held.leaves = found.zero_s.has_value();
}

// The ball is in contact until it is above the plane by more than round-off.
void Contacts::let_go(double t_s, const std::vector<double>& y, std::vector<Event>& events,
                      dynamics::Instant<double>& instant) {
  for (std::size_t k = 0; k < held_.size();) {
    if (!held_[k].leaves) {
      ++k;
      continue;
    }
    Pair& pair = pairs_.emplace_back();
    static_cast<ContactPair&>(pair) = held_[k];
    pair.in_contact = true;
    pair.left_s = t_s;
    events.push_back(
        dynamics::event_at(t_s, EventKind::separate, pair, gap(scene_, equations_.layout(), pair, y.data())));
    instant.lifted.push_back(dynamics::ball_of(scene_, pair));
    held_.erase(held_.begin() + static_cast<std::ptrdiff_t>(k));
  }
}

// ---- events within a step
// ----------------------------------------------------------------------------------------------
void Contacts::undecided(const ContactPair& pair, double t_s) {
  failure_ = "CVODE: whether " + name(pair.a) + " and " + name(pair.b) + " touch at t = " + format_double(t_s) +
             " s is not decided";
  valid_until_failure_ = true;
}

void Contacts::find_gaps(Pair& pair, const Trajectory& path, const Reaches& reaches, double from_s, double& to_s,
                         bool& any, std::vector<Passage>& passages) {
  const double reported_m = kPassage * size_m_, tolerance_m = kContactTolerance * size_m_;
  if (!pair.in_contact && reaches.least_gap(pair) > reported_m) {
    pair.gap = {true, false, true, 0};
    return;
  }
  const auto search = [&](double shift_m, double sign, double reported, Watch& watch) {
    const SwitchingFunction f = gap_function(scene_, equations_.layout(), pair, path, shift_m, sign);
    const Searched found =
        first_zero(f, path.unit(from_s), path.unit(to_s), f.flat ? reported : reported * 2 * f.level, watch);
    if (found.open) undecided(pair, path.time(*found.open));
    if (found.zero || found.open) {
      any = true;
      to_s = std::clamp(path.time(found.zero ? *found.zero : *found.open), from_s, to_s);
    }
    for (const Minimum& each : found.minima) passages.push_back({path.time(each.u), pair});
  };
  if (pair.in_contact) {
    search(-tolerance_m, 1, 0, pair.gap);
    search(2 * tolerance_m, -1, 0, pair.opening);
  } else search(0, 1, reported_m, pair.gap);
}

bool Contacts::first_event(const Trajectory& path, const Reaches& reaches, const Rate& rate, double from_s,
                           double& to_s, std::vector<Passage>& passages) {
  bool any = false;
  for (Held& held : held_) find_lift(held, path, rate, from_s, to_s, any);
  const double lift_s = to_s;
  for (Pair& pair : pairs_) find_gaps(pair, path, reaches, from_s, to_s, any, passages);
  if (to_s < lift_s)
    for (Held& held : held_) held.leaves = false;
  return any;
}

void Contacts::check(double t_s, const std::vector<double>& y, const Rate& rate) {
  for (const Pair& pair : pairs_)
    if (gap(scene_, equations_.layout(), pair, y.data()).gap_m < -kMissedOverlap * size_m_)
      failure_ = "CVODE: " + name(pair.a) + " and " + name(pair.b) + " overlap at t = " + format_double(t_s) +
                 " s without an impact (a lasting contact): not covered";
  std::vector<double> dydt(y.size());
  for (const Held& held : held_) {
    const int ball = dynamics::ball_of(scene_, held);
    if (gap(scene_, equations_.layout(), held, y.data()).gap_m > 1e-6 * size_m_)
      failure_ = "CVODE: " + name(ball) + " separates from the plane it rests on at t = " + format_double(t_s) +
                 " s: not covered";
    if (held.friction == 0 || held.constant) continue;
    rate(t_s, y.data(), dydt.data());
    const double tiny =
        rtol_ * length(dynamics::read3(&y[equations_.layout().slots[ball].velocity])) + 1e3 * atol_m_per_s_;
    if (!dynamics::friction_acts(scene_, equations_.layout(), held, y.data(), dydt.data(), tiny)) continue;
    failure_ = "CVODE: " + name(ball) +
               " rests on a plane with friction and is pushed along it at t = " + format_double(t_s) +
               " s: not covered";
    valid_until_failure_ = true;
  }
}

}  // namespace atwood::cvode
