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
constexpr double kGapRoundOff = is_wide<S> ? 1e-27 : 1e-11;  // of a gap, relative to the positions it is computed from
// Flights shorter than kSummedFlight (relative to the duration of the run) are summed as a geometric series if the time
// of rest is then known to within kRestTimeTolerance of the run; flights shorter than kAlwaysSummedFlight in any case.
template <class S> constexpr double kSummedFlight = is_wide<S> ? 1e-10 : 1e-4;
template <class S> constexpr double kAlwaysSummedFlight = is_wide<S> ? 1e-12 : 1e-4;
constexpr double kRestTimeTolerance = 1e-24;
// In units of the gap's round-off: the next impact of a lower flight could not be located.
template <class S> constexpr double kMinHeightInRoundOff = is_wide<S> ? 1e3 : 4;
constexpr double kSpeedAtRest = 1e-5;      // of the speed that the pull to the plane gives during the run
constexpr int kMaxTries = 100;             // of the search for a touch
constexpr double kPassageDistance = 1e-3;  // of the pair's size: a closest approach with a larger gap is not a passage

template <class S> S position_magnitude(const Scene& scene, const dynamics::Layout& layout, int body, const S* y) {
  const Body& given = scene.bodies[body];
  if (const auto* plane = std::get_if<Plane>(&given.shape)) return std::fabs(plane->offset_m);
  S sum = 0;
  if (const auto* sphere = std::get_if<Sphere>(&given.shape)) sum = sphere->radius_m;
  const int at = layout.slots[body].position;
  for (int k = 0; k < 3; ++k) sum += at < 0 ? S(std::fabs(given.position_m[k])) : magnitude(y[at + k]);
  return sum;
}

}  // namespace

template <class S>
Impacts<S>::Impacts(const Scene& scene, dynamics::Dynamics<S>& dynamics, dynamics::Dynamics<double>& double_dynamics,
                    double t_end_s)
    : scene_(scene), dynamics_(dynamics), double_dynamics_(double_dynamics), free_dynamics_(scene, t_end_s),
      t_end_s_(t_end_s), fastest_(scene.bodies.size(), S(0)) {
  const dynamics::ContactPairs found = dynamics::contact_pairs(scene);
  pairs_ = found.pairs;
  if (!found.unsupported.empty()) failure_ = found.unsupported + " is not covered by the extended truth";
  for (const Pair& pair : pairs_)
    if (pair.compliant)
      failure_ = "the contact of `" + scene.bodies[pair.a].name + "` and `" + scene.bodies[pair.b].name +
                 "` with a compliant contact law is not covered by the extended truth";
}

template <class S> S Impacts<S>::gap_tolerance(const Pair& pair, const S* y) const {
  return S(kGapRoundOff<S>) * (position_magnitude(scene_, dynamics_.layout(), pair.a, y) +
                               position_magnitude(scene_, dynamics_.layout(), pair.b, y));
}

template <class S> S Impacts<S>::speed_tolerance(const Pair& pair) const {
  return S(kGapRoundOff<S>) * (fastest_[pair.a] + fastest_[pair.b]);
}

template <class S> void Impacts<S>::update_fastest(const S* y) {
  for (std::size_t i = 0; i < fastest_.size(); ++i) {
    const int at = dynamics_.layout().slots[i].velocity;
    for (int k = 0; k < 3 && at >= 0; ++k) fastest_[i] = std::max(fastest_[i], magnitude(y[at + k]));
  }
}

template <class S>
std::optional<BounceSeries<S>> Impacts<S>::bring_to_rest(const Pair& pair, S t, S* y, int interval,
                                                         std::vector<Event>& events) {
  const dynamics::LastBounces<S> last =
      dynamics::last_bounces(scene_, dynamics_, pair, t, y, interval, speed_tolerance(pair));
  if (!last.attracted || (pair.restitution >= 1 && !last.at_rest)) return {};
  const Gap<S> now = gap(scene_, dynamics_.layout(), pair, y);
  const S height = magnitude(now.rate_m_per_s) * last.flight_s / 4;
  const bool located = height > S(kMinHeightInRoundOff<S>) * gap_tolerance(pair, y);
  if (located && last.flight_s > kSummedFlight<S> * t_end_s_) return {};
  const int ball = last.series.ball;
  if (ball < 0) {
    failure_ = "`" + scene_.bodies[pair.a].name + "` comes to rest on `" + scene_.bodies[pair.b].name +
               "`, which is not a plane: not covered by the extended truth";
    return {};
  }
  if (dynamics::friction_acts(scene_, dynamics_.layout(), pair, y, last.dydt.data(), speed_tolerance(pair))) {
    failure_ =
        "`" + scene_.bodies[ball].name +
        "` comes to rest on a plane with friction and slides or accelerates along it: not covered by the extended truth";
    return {};
  }
  const bool known = last.converges && last.series.bar_s <= kRestTimeTolerance * t_end_s_;
  if (!known && located && last.flight_s > kAlwaysSummedFlight<S> * t_end_s_) return {};
  if (!last.converges) {
    failure_ = "the time at which `" + scene_.bodies[ball].name +
               "` comes to rest is not bounded: its restitution is too close to 1 for the change of its acceleration";
    return {};
  }
  BounceSeries<S> made = last.series;
  made.has_event = made.t_rest <= t_end_s_ && (t > 0 || magnitude(now.rate_m_per_s) > 0);
  std::copy(last.y_at_rest.begin(), last.y_at_rest.end(), y);
  dynamics_.hold_on_plane(ball, made.normal);
  double_dynamics_.hold_on_plane(ball, made.normal);
  // What is left of its normal velocity is the round-off of its accelerations.
  fastest_[ball] =
      std::max(fastest_[ball], S(kSpeedAtRest) * magnitude(pull_to_plane(pair, t, y, interval)) * S(t_end_s_));
  if (made.has_event) events.push_back(dynamics::event_at(made.t_rest, EventKind::rest, pair, now));
  return made;
}

template <class S> Instant<S> Impacts<S>::resolve(S t, S* y, int interval, std::vector<Event>& events) {
  Instant<S> made;
  made.t = t;
  made.interval = interval;
  made.first_event = events.size();
  update_fastest(y);
  if (t == 0)
    for (const Pair& pair : pairs_)
      if (gap(scene_, dynamics_.layout(), pair, y).gap_m < -1e18 * gap_tolerance(pair, y))
        failure_ = "`" + scene_.bodies[pair.a].name + "` and `" + scene_.bodies[pair.b].name + "` overlap at the start";
  for (bool changed = true; changed && failure_.empty();) {
    changed = false;
    std::vector<Pair> contacts;
    std::vector<S> speed_tolerances;
    for (const Pair& pair : pairs_) {
      const Gap<S> now = gap(scene_, dynamics_.layout(), pair, y);
      if (now.gap_m > gap_tolerance(pair, y)) continue;
      contacts.push_back(pair);
      speed_tolerances.push_back(speed_tolerance(pair));
      if (now.rate_m_per_s < -speed_tolerance(pair)) {
        if (const auto refused = dynamics::impact_refusal(scene_, dynamics_.layout(), pair, held_, t, y);
            !refused.why.empty()) {
          failure_ = refused.why + " by the extended truth";
          valid_until_failure_ = refused.valid_until_failure;
          return made;
        }
        changed = true;
        if (t > 0) made.gap_error_m = std::max(made.gap_error_m, magnitude(now.gap_m));
      }
    }
    if (changed) {
      if (!progress_.advances(t)) failure_ = progress_.failure(t);
      dynamics::ImpactOutcome<S> outcome =
          dynamics::resolve_impacts(scene_, dynamics_.layout(), contacts, speed_tolerances, y);
      if (!outcome.why.empty()) {
        failure_ = "the outcome of simultaneous impacts " + outcome.why;
        valid_until_failure_ = true;
        return made;
      }
      for (std::size_t k = 0; k < outcome.impacts.size(); ++k)
        dynamics::append_impacts(scene_, dynamics_.layout(), outcome.impacts[k],
                                 k + 1 < outcome.impacts.size() ? outcome.impacts[k + 1].before.data() : y, t, events);
      for (auto& impact : outcome.impacts) made.impacts.push_back(std::move(impact));
      update_fastest(y);
    }
    for (const Pair& pair : contacts) {
      if (!failure_.empty()) break;
      if (gap(scene_, dynamics_.layout(), pair, y).gap_m > gap_tolerance(pair, y)) continue;
      if (auto series = bring_to_rest(pair, t, y, interval, events)) {
        held_.push_back(pair);
        std::erase_if(pairs_, [&](const Pair& each) { return each.a == pair.a && each.b == pair.b; });
        made.series.push_back(std::move(*series));
        changed = true;
      }
    }
  }
  made.after.assign(y, y + dynamics_.size());
  return made;
}

// The acceleration into the plane without its reaction: what the plane's normal force is proportional to.
template <class S> S Impacts<S>::pull_to_plane(const Pair& pair, S t, const S* y, int interval) const {
  std::vector<S> dydt(dynamics_.size());
  free_dynamics_.rate(t, y, dydt.data(), interval);
  const int ball = dynamics::ball_of(scene_, pair);
  const S along = dynamics::dot(dynamics::read3(&dydt[dynamics_.layout().slots[ball].velocity]),
                                gap(scene_, dynamics_.layout(), pair, y).normal);
  return ball == pair.b ? -along : along;
}

template <class S>
typename Impacts<S>::Lift Impacts<S>::find_lift(const StepCourse<S>& course, int interval, const StateAt& state_at,
                                                S until) {
  Lift first;
  const DenseStep<S>& step = course.step();
  const auto fail = [&](const Pair& pair, S t, const std::string& what) {
    failure_ = "`" + scene_.bodies[dynamics::ball_of(scene_, pair)].name + "` " + what +
               " at t = " + format_double(static_cast<double>(t)) + " s";
    valid_until_failure_ = true;
    failed_at_ = t;
  };
  for (const Pair& pair : held_) {
    const auto slides = [&](const std::vector<S>& y, const std::vector<S>& f) {
      return dynamics::friction_acts(scene_, dynamics_.layout(), pair, y.data(), f.data(), speed_tolerance(pair));
    };
    if (slides(step.y0, step.f0) || (until >= step.span / 2 && slides(step.ym, step.fm)) ||
        (until >= step.span && slides(step.y1, step.f1)))
      fail(pair, step.t,
           "begins to slide or accelerates along the plane with friction on which it rests: not covered,");
    const Fall<S> fall = first_fall<S>(
        course, [&](S t, const S* y) { return pull_to_plane(pair, t, y, interval); },
        [&](S tau) -> std::optional<S> {
          const std::vector<S> y = state_at(tau);
          return pull_to_plane(pair, step.t + tau, y.data(), interval);
        });
    if (fall.undecided) return {std::nullopt, pair, true};
    if (fall.grazes && *fall.grazes <= until)
      fail(pair, step.t + *fall.grazes, "rests on its plane without weight: whether it leaves is not decided,");
    if (!fall.located) fail(pair, step.t, "leaves its plane; the instant was not located, in the step");
    if (fall.tau && (!first.tau || *fall.tau < *first.tau)) first = {fall.tau, pair, false};
  }
  return first;
}

template <class S> S Impacts<S>::location_span(const Pair& pair, const S* y) const {
  const S speed = magnitude(gap(scene_, dynamics_.layout(), pair, y).rate_m_per_s);
  return speed > 0 ? gap_tolerance(pair, y) / speed : S(0);
}

template <class S> std::vector<S> Impacts<S>::speeds_at_rest(S t, const S* y, int interval) const {
  std::vector<S> made(held_.empty() ? 0 : dynamics_.size(), S(0));
  for (const Pair& pair : held_)
    made[dynamics_.layout().slots[dynamics::ball_of(scene_, pair)].velocity] =
        S(kSpeedAtRest) * magnitude(pull_to_plane(pair, t, y, interval)) * S(t_end_s_);
  return made;
}

template <class S>
Instant<S> Impacts<S>::release(const Pair& pair, S t, const S* y, int interval, std::vector<Event>& events) {
  Instant<S> made;
  made.t = t;
  made.interval = interval;
  made.first_event = events.size();
  const int ball = dynamics::ball_of(scene_, pair);
  dynamics_.release_from_plane(ball);
  double_dynamics_.release_from_plane(ball);
  events.push_back(dynamics::event_at(t, EventKind::separate, pair, gap(scene_, dynamics_.layout(), pair, y)));
  made.lifted.push_back(ball);
  pairs_.push_back(pair);
  std::erase_if(held_, [&](const Pair& each) { return each.a == pair.a && each.b == pair.b; });
  made.after.assign(y, y + dynamics_.size());
  return made;
}

// The root of the gap g with g(high) < 0 and g > 0 between low and the root. Newton's method, from low = 0 started at
// the root of the parabola through g(0), g'(0), g(high); an iterate outside the bracket is replaced by the bracket's
// middle.
template <class S>
typename Impacts<S>::Touch Impacts<S>::locate(const Pair& pair, const S* before, S low, S high, S gap_high,
                                              const StateAt& state_at) const {
  const Gap<S> start = gap(scene_, dynamics_.layout(), pair, before);
  S tau = low > 0 ? S(-1) : high;
  if (!(low > 0)) {
    const S half_acceleration = (gap_high - start.gap_m - start.rate_m_per_s * high) / (high * high);
    const S discriminant = start.rate_m_per_s * start.rate_m_per_s - 4 * half_acceleration * start.gap_m;
    // The larger root of the parabola, without cancellation when the gap already decreases (rate < 0).
    if (discriminant > 0) {
      const S root = dynamics::sqrt(discriminant);
      tau = start.rate_m_per_s < 0 ? 2 * start.gap_m / (root - start.rate_m_per_s)
                                   : -(start.rate_m_per_s + root) / (2 * half_acceleration);
    }
  }
  const S tolerance = gap_tolerance(pair, before) * S(is_wide<S> ? 1e-5 : 1e-2);
  for (int tries = 0; tries < kMaxTries; ++tries) {
    if (!(tau > low && tau <= high)) tau = low + (high - low) / 2;
    const std::vector<S> state = state_at(tau);
    const Gap<S> now = gap(scene_, dynamics_.layout(), pair, state.data());
    const bool within_round_off =
        magnitude(now.gap_m) <= std::max(gap_tolerance(pair, before), gap_tolerance(pair, state.data()));
    if (magnitude(now.gap_m) <= tolerance || high - low <= tolerance * S(1e-3) * high)
      return {tau, pair, within_round_off};
    if (now.gap_m > 0) low = tau;
    else high = tau;
    if (tries + 1 == kMaxTries) return {tau, pair, within_round_off};
    tau = now.rate_m_per_s < 0 ? tau - now.gap_m / now.rate_m_per_s : S(-1);
  }
  return {tau, pair, false};
}

// Regula falsi on the gap's rate, the value at the end that stays being halved (Illinois), and bisection while that is
// slow. It ends early at an overlap, and when the gap cannot close within the rest of the bracket at four times its
// present rate.
template <class S>
std::optional<typename Impacts<S>::Passage> Impacts<S>::closest_approach(const Pair& pair, S low, S high,
                                                                         const StateAt& state_at) const {
  Passage found;
  found.pair = pair;
  const auto rate_at = [&](S tau) {
    found.tau = tau;
    found.y = state_at(tau);
    return gap(scene_, dynamics_.layout(), pair, found.y.data());
  };
  S rate_low = rate_at(low).rate_m_per_s, rate_high = rate_at(high).rate_m_per_s;
  if (!(rate_low < 0 && rate_high > 0)) return std::nullopt;
  const S size = position_magnitude(scene_, dynamics_.layout(), pair.a, found.y.data()) +
                 position_magnitude(scene_, dynamics_.layout(), pair.b, found.y.data());
  const S round_off = S(kGapRoundOff<S>) * size;
  for (int tries = 0; tries < 120; ++tries) {
    const S secant = low + (high - low) * rate_low / (rate_low - rate_high);
    const Gap<S> now = rate_at(tries % 4 < 3 && secant > low && secant < high ? secant : low + (high - low) / 2);
    if (now.gap_m < -round_off) return found;
    // The gap's rate is monotone in the bracket.
    const S remaining = 4 * magnitude(now.rate_m_per_s) * (high - low);
    if (remaining <= round_off / 16 || now.gap_m > 64 * remaining + round_off) return found;
    if (now.rate_m_per_s < 0) {
      low = found.tau;
      rate_low = now.rate_m_per_s;
      rate_high /= 2;
    } else {
      high = found.tau;
      rate_high = now.rate_m_per_s;
      rate_low /= 2;
    }
  }
  found.located = false;
  return found;
}

// A step with what its pairs share: its middle in double, and how far each body goes from there.
template <class S> struct Impacts<S>::Step {
  const StepCourse<S>& course;
  const StateAt& state_at;
  std::vector<double> middle, way_m;

  Step(const StepCourse<S>& given, const dynamics::Layout& layout, const StateAt& at)
      : course(given), state_at(at), way_m(layout.slots.size(), 0.0) {
    for (const S& x : course.step().ym) middle.push_back(static_cast<double>(x));
    constexpr int parts = 16;
    for (int k = 0; k <= parts; ++k) {
      const std::vector<S> state = course.state(S(k) / parts);
      for (std::size_t i = 0; i < way_m.size(); ++i)
        if (const int slot = layout.slots[i].position; slot >= 0) {
          double square = 0;
          for (int c = 0; c < 3; ++c) {
            const double d = static_cast<double>(state[slot + c]) - middle[slot + c];
            square += d * d;
          }
          way_m[i] = std::max(way_m[i], std::sqrt(square));
        }
    }
    for (double& way : way_m) way *= 1.25;  // between the parts, and dense output's error
  }
};

// A gap changes by no more than its bodies move.
template <class S> bool Impacts<S>::is_far(const Pair& pair, const Step& step) const {
  const double gap_m = gap(scene_, dynamics_.layout(), pair, step.middle.data()).gap_m;
  const double size = position_magnitude(scene_, dynamics_.layout(), pair.a, step.middle.data()) +
                      position_magnitude(scene_, dynamics_.layout(), pair.b, step.middle.data());
  return gap_m > step.way_m[pair.a] + step.way_m[pair.b] + kPassageDistance * size;
}

// The switching function is the gap g of a surface, and g (g + 2 R) = |d|^2 - R^2 of two spheres, R the sum of their
// radii, which is smooth where their centres meet.
template <class S> void Impacts<S>::search(const Pair& pair, const Step& step, Found& found) const {
  const dynamics::Layout& layout = dynamics_.layout();
  const S *before = step.course.step().y0.data(), *after = step.course.step().y1.data();
  const S taken = step.course.step().span;
  if (is_far(pair, step)) return;
  const auto *a = std::get_if<Sphere>(&scene_.bodies[pair.a].shape),
             *b = std::get_if<Sphere>(&scene_.bodies[pair.b].shape);
  const bool spheres = a != nullptr && b != nullptr;
  const S reach = spheres ? S(a->radius_m) + S(b->radius_m) : S(0);
  const Course course = step.course.of([&](S, const S* y) {
    const S g = gap(scene_, layout, pair, y).gap_m;
    return spheres ? g * (g + 2 * reach) : g;
  });
  const Gap<S> first = gap(scene_, layout, pair, before), last = gap(scene_, layout, pair, after);
  const S round_off = std::max(gap_tolerance(pair, before), gap_tolerance(pair, after));
  const double unit = spheres ? static_cast<double>(2 * reach) : 1;         // of the switching function a metre
  if (course.largest <= 4 * unit * static_cast<double>(round_off)) return;  // they move together
  const auto slope = [&](const Gap<S>& at) {
    return static_cast<double>(taken * at.rate_m_per_s * (spheres ? 2 * (at.gap_m + reach) : S(1)));
  };
  if (!course.is_positive() && !course.has_slopes(slope(first), slope(last), unit * static_cast<double>(round_off))) {
    found.undecided = pair;
    return;
  }
  const double size = static_cast<double>(position_magnitude(scene_, layout, pair.a, before) +
                                          position_magnitude(scene_, layout, pair.b, before));
  const auto touches = [&](S low, S high, S gap_high) {
    found.touch = locate(pair, before, low, high, gap_high, step.state_at);
  };
  for (const Minimum& at : course.minima) {
    if (at.value > course.error + kPassageDistance * size * unit) continue;
    if (found.touch && S(at.left) * taken >= found.touch->tau) return;
    if (!course.shows(at)) {
      if (at.value > course.error) continue;
      found.undecided = pair;
      return;
    }
    // A rate within round-off at the start: the closest approach was earlier.
    if (at.left == 0 && first.rate_m_per_s >= -speed_tolerance(pair)) continue;
    std::optional<Passage> closest = closest_approach(pair, S(at.left) * taken, S(at.right) * taken, step.state_at);
    if (!closest) {
      found.undecided = pair;
      return;
    }
    const S least = gap(scene_, layout, pair, closest->y.data()).gap_m;
    if (closest->located && least < -round_off) return touches(S(at.left) * taken, closest->tau, least);
    found.passages.push_back(std::move(*closest));
  }
  if (last.gap_m < -round_off && (last.rate_m_per_s < 0 || first.gap_m >= -round_off)) {
    // A ball that has left its plane begins at rest on it.
    const bool begins_at_rest = first.gap_m <= round_off && magnitude(first.rate_m_per_s) <= speed_tolerance(pair);
    if (begins_at_rest && course.last_maximum == 0) {
      found.undecided = pair;
      return;
    }
    return touches(S(course.minima.empty() && !begins_at_rest ? 0.0 : course.last_maximum) * taken, taken, last.gap_m);
  }
  if (first.rate_m_per_s < -speed_tolerance(pair) && magnitude(last.rate_m_per_s) <= speed_tolerance(pair))
    found.passages.push_back({taken, pair, std::vector<S>(after, after + dynamics_.size()), true});
}

template <class S>
typename Impacts<S>::Found Impacts<S>::search(const StepCourse<S>& course, const StateAt& state_at) const {
  const Step step(course, dynamics_.layout(), state_at);
  Found all;
  for (const Pair& pair : pairs_) {
    Found found;
    search(pair, step, found);
    if (found.undecided) return found;
    const bool earlier = found.touch && (!all.touch || !found.touch->located || found.touch->tau < all.touch->tau);
    if (earlier && (!all.touch || all.touch->located)) all.touch = found.touch;
    for (Passage& each : found.passages) all.passages.push_back(std::move(each));
  }
  if (all.touch) std::erase_if(all.passages, [&](const Passage& each) { return each.tau > all.touch->tau; });
  std::sort(all.passages.begin(), all.passages.end(), [](const Passage& a, const Passage& b) { return a.tau < b.tau; });
  return all;
}

template <class S> void Impacts<S>::end_undecided(S t, const Pair& pair, const char* what) {
  failure_ = "whether `" + scene_.bodies[pair.a].name + "` and `" + scene_.bodies[pair.b].name + "` " + what +
             " is not decided in the step from t = " + format_double(static_cast<double>(t)) + " s";
  valid_until_failure_ = true;
}

template <class S> void Impacts<S>::check_located(S t, const Pair& pair, bool located) {
  if (located || !failure_.empty()) return;
  failure_ = "the search for the instant at which `" + scene_.bodies[pair.a].name + "` and `" +
             scene_.bodies[pair.b].name +
             "` touch did not converge in the step from t = " + format_double(static_cast<double>(t)) + " s";
  valid_until_failure_ = true;
}

template class Impacts<double>;
template class Impacts<Wide>;

}  // namespace atwood::extended
