// Where in a step the first condition falls that must stay positive.
#include <algorithm>

#include "contact/event/fall.hpp"

namespace atwood::event {

namespace {

// ---- impacts --------------------------------------------------------------------------------------------------------
// Where in (low, high] a gap falls through zero that is at or above it at `low` and below at `high`. Newton on the
// gap, from where the parabola through the start and the end falls through zero (free flight onto a plane is that),
// kept in a bracket; a gap that starts at zero, after an impact, rises first. Ends where corrections no longer shrink:
// what is left of the gap is round-off.
template <class S> S refine(Flow<S>& flow, const Feature<S>& feature, S low, S high, S gap_high) {
  const bool leaves = feature.rate > S(0);
  const S rise = feature.rate * flow.h_s * high, bend = gap_high - feature.gap - rise;
  const S root = real::sqrt(real::max(rise * rise - S(4) * bend * feature.gap, S(0)));
  const S guess = leaves ? (rise + root) / (S(-2) * bend) : S(2) * feature.gap / (root - rise);
  S theta = guess > S(0) && guess < S(1) && guess * high > low ? guess * high : high, last = high;
  for (int i = 0; i < 100; ++i) {
    const Sight<S> sight = sight_of(flow.run, feature, flow.at(theta));
    const S slope = sight.rate * flow.h_s;
    if (sight.gap > S(0) || (leaves && slope >= S(0))) low = theta;
    else high = theta;
    S next = slope < S(0) ? theta - sight.gap / slope : low;
    S change = real::abs(next - theta);
    if (change <= real::epsilon<S>() * theta) break;
    if (change >= last / S(2) && real::abs(sight.gap) <= flow.run.gap_round_off()) break;
    if (!(next > low && next < high)) {
      next = low + (high - low) / S(2);
      change = high;
    }
    if (high - low <= real::epsilon<S>() * high) break;
    last = change;
    theta = next;
  }
  return flow.probed;
}

// The end of the first part of [0, 1] in which the gap falls below zero, and the gap there; above 1 if there is none. A
// dip inside the step shows as a gap that falls at the start and rises at the end: its lowest point is sought by the
// sign of the rate.
template <class S> struct Overlap { S theta = S(2), gap{}; };
template <class S> Overlap<S> overlap_within(Flow<S>& flow, const Feature<S>& feature) {
  const Overlap<S> none;
  if (feature.gap_end < S(0)) {
    const bool leaves = feature.gap <= S(0) && feature.rate_end >= S(0) && feature.gap_end >= feature.gap;
    return leaves ? none : Overlap<S>{S(1), feature.gap_end};
  }
  if (!(feature.rate < S(0) && feature.rate_end > S(0))) return none;
  // Bodies that parted at the start of the step, by round-off not at once: no dip, or the touch would be found for
  // ever.
  if (feature.gap <= flow.run.gap_round_off() && feature.rate >= -flow.run.approach_round_off()) return none;
  // A gap that falls and rises again is convex there: it stays above its tangents at both ends.
  const S fall = feature.rate * flow.h_s, rise = feature.rate_end * flow.h_s;
  if (feature.gap + fall * ((feature.gap_end - rise - feature.gap) / (fall - rise)) > S(0)) return none;
  S low = S(0), high = S(1);
  for (int i = 0; i < 60; ++i) {  // bisection on the rate; stops at the first overlap
    const S middle = low + (high - low) / S(2);
    const Sight<S> sight = sight_of(flow.run, feature, flow.at(middle));
    if (sight.gap <= S(0)) return {middle, sight.gap};
    if (sight.rate < S(0)) low = middle;
    else high = middle;
    if (high - low < real::epsilon<S>()) break;
  }
  return none;
}

// A gap that starts closed with no rate, by round-off, has been let go because it rises. Where within (0, high] it
// has done so; 0: nowhere, or it starts otherwise.
template <class S> S rises_until(Flow<S>& flow, const Feature<S>& feature, S high) {
  const EventRun<S>& run = flow.run;
  if (feature.gap > run.gap_round_off() || real::abs(feature.rate) > run.approach_round_off()) return S(0);
  for (S theta = high / S(2); theta > high * S(0x1p-40); theta = theta / S(2))
    if (sight_of(flow.run, feature, flow.at(theta)).gap > run.gap_round_off()) return theta;
  return S(0);
}

template <class S> S touch_of(Flow<S>& flow, const Feature<S>& feature) {
  if (feature.gap <= S(0) && feature.rate < -flow.run.approach_round_off()) return S(0);
  const Overlap<S> overlap = overlap_within(flow, feature);
  if (overlap.theta > S(1)) return overlap.theta;
  // Touching and neither approaching nor leaving, by round-off: not an impact.
  if (real::abs(feature.gap) <= flow.run.gap_round_off() && real::abs(feature.gap_end) <= flow.run.gap_round_off() &&
      real::abs(feature.rate_end) <= flow.run.approach_round_off())
    return S(2);
  return refine(flow, feature, rises_until(flow, feature, overlap.theta), overlap.theta, overlap.gap);
}

// Two edges count from when they cross: where they do so overlapping, another feature has met before.
template <class S> S touch_of_edges(Flow<S>& flow, const Feature<S>& feature) {
  const S theta = touch_of(flow, feature);
  if (!(theta > S(0) && theta <= S(1))) return theta;
  const S gap = sight_of(flow.run, feature, flow.at(theta)).gap;
  return real::abs(gap) <= S(4) * flow.run.gap_round_off() ? theta : S(2);
}

// ---- conditions of lasting contacts ---------------------------------------------------------------------------------
// last evaluation; slips as of the last look at it.
template <class S> S value_of(const EventRun<S>& run, Condition condition, Contact<S>& contact) {
  const ShapePair<S>& pair = run.pairs[run.features[contact.feature].pair];
  switch (condition) {
    case Condition::force: return contact.normal_N;
    case Condition::cone: return pair.friction * contact.normal_N - norm(contact.friction_N);
    case Condition::couple: return pair.rolling_friction_m * contact.normal_N - norm(contact.couple_N_m);
    case Condition::slip: return dot(contact.u, contact.slip_direction);
    case Condition::facet: return within_facet(run, contact) + run.gap_round_off();  // 0 above inner edges
    case Condition::pressed: return run.rises_enough + normal_acceleration(run, contact, run.dydt.data());
    default: return dot(contact.w, contact.roll_direction);
  }
}

bool about_forces(Condition condition) {
  return condition == Condition::force || condition == Condition::cone || condition == Condition::couple ||
         condition == Condition::pressed;
}

template <class S> bool applies(const EventRun<S>& run, Condition condition, const Contact<S>& contact) {
  switch (condition) {
    case Condition::force:
    case Condition::pressed: return true;
    case Condition::cone: return contact.mode == Mode::sticks;
    case Condition::couple: return contact.turning == Turning::held;
    case Condition::slip: return contact.mode == Mode::slips && !contact.waits;
    case Condition::facet: return has_ends(run, contact);
    default: return contact.turning == Turning::rolls;
  }
}

// The conditions of all contacts at one theta of a step, looked at no more than once until theta changes.
template <class S> struct Watch {
  Flow<S>& flow;
  S theta = S(-1);
  bool forces = false;

  S value(Condition condition, int index, S at) {
    if (theta != at || (about_forces(condition) && !forces)) {
      EventRun<S>& run = flow.run;
      const S* y = at == S(0) ? run.y.data() : at == S(1) ? run.y_new.data() : flow.at(at);
      theta = at;
      forces = about_forces(condition);
      if (forces) {
        run.model.system().rate(flow.t_s + at * flow.h_s, y, run.dydt.data());
        for (Contact<S>& contact : run.contacts)
          if (!contact.carries) see_contact(run, contact);
      } else {
        see_contacts(run, y);
      }
      run.sights_at_end = at == S(1);
    }
    return value_of(flow.run, condition, flow.run.contacts[index]);
  }
};

// Illinois on a condition's value: positive at low (or unknown there), negative at high.
template <class S> S locate(Watch<S>& watch, Condition condition, int index, S f_low, S f_high, S high) {
  S low = S(0);
  if (!(f_low > S(0))) return S(0);
  for (int i = 0, side = 0; i < 100 && high - low > real::epsilon<S>() * high; ++i) {
    S theta = (low * f_high - high * f_low) / (f_high - f_low);
    if (!(theta > low && theta < high)) theta = low + (high - low) / S(2);
    if (!(theta > low && theta < high)) break;
    const S f = watch.value(condition, index, theta);
    if (f == S(0)) return theta;
    if (f > S(0)) {
      low = theta;
      f_low = f;
      if (side == 1) f_high = f_high / S(2);
      side = 1;
    } else {
      high = theta;
      f_high = f;
      if (side == -1) f_low = f_low / S(2);
      side = -1;
    }
  }
  return high;
}

template <class S> void search(Watch<S>& watch, Condition condition, Fall<S>& first) {
  const EventRun<S>& run = watch.flow.run;
  for (int i = 0; i < static_cast<int>(run.contacts.size()); ++i) {
    const Contact<S>& contact = run.contacts[i];
    if (contact.carries == (condition == Condition::pressed) || !applies(run, condition, contact)) continue;
    const S until = real::min(first.theta, S(1)), end = watch.value(condition, i, until);
    const bool bounded = about_forces(condition) && condition != Condition::pressed;
    const S tiny = bounded ? -S(64) * real::epsilon<S>() * contact.largest_N : S(0);
    if (!(end < tiny)) continue;
    const S theta = locate(watch, condition, i, watch.value(condition, i, S(0)), end, until);
    if (theta <= S(1) && theta < first.theta) first = {theta, condition, i};
  }
}

// ---- the kink of quadratic drag -------------------------------------------------------------------------------------
template <class S> Vec3<S> through_air(const EventRun<S>& run, const Wind<S>& wind, const S* y) {
  return load3(y + run.model.offset(wind.body) + kAtVelocity) - wind.velocity_W;
}

}  // namespace

template <class S> void earliest_touch(Flow<S>& flow, Fall<S>& first) {
  EventRun<S>& run = flow.run;
  for (const int p : run.near) {
    const ShapePair<S>& pair = run.pairs[p];
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      const Feature<S>& feature = run.features[f];
      if (feature.lasting || (feature.gap > S(0) && feature.gap_end > S(0) && feature.rate_end <= S(0))) continue;
      const S theta = feature.knob.edge ? touch_of_edges(flow, feature) : touch_of(flow, feature);
      if (theta <= S(1) && theta < first.theta) first = {theta, Condition::gap, f};
    }
  }
}

template <class S> void earliest_switch(Flow<S>& flow, Fall<S>& first) {
  const EventRun<S>& run = flow.run;
  Watch<S> watch{flow};
  if (run.near_bound)
    for (const Condition condition : {Condition::force, Condition::cone, Condition::couple})
      search(watch, condition, first);
  if (run.carrying < static_cast<int>(run.contacts.size())) search(watch, Condition::pressed, first);
  for (const Condition condition : {Condition::slip, Condition::roll, Condition::facet})
    search(watch, condition, first);
}

// Where in the step a body's velocity through the air has turned square to what it was at the start. Steps are cut
// there: across the kink of |u| u no method keeps more than third order. False position (Illinois), from the smooth
// side.
template <class S> void earliest_calm(Flow<S>& flow, Fall<S>& first) {
  EventRun<S>& run = flow.run;
  for (std::size_t i = 0; i < run.winds.size(); ++i) {
    const Wind<S>& wind = run.winds[i];
    const Vec3<S> u0 = through_air(run, wind, run.y.data()), u1 = through_air(run, wind, run.y_new.data());
    const S tiny = S(1024) * real::epsilon<S>();
    S low = S(0), high = S(1), f_low = dot(u0, u0), f_high = dot(u0, u1);
    if (!(f_high < S(0)) || f_low < tiny * tiny * dot(u1, u1)) continue;
    const S enough = real::epsilon<S>() * f_low;
    S theta = high;
    for (int k = 0, side = 0; k < 60 && high - low > real::epsilon<S>() * high; ++k) {
      theta = (low * f_high - high * f_low) / (f_high - f_low);
      if (!(theta > low && theta < high)) theta = low + (high - low) / S(2);
      const S f = dot(u0, through_air(run, wind, flow.at(theta)));
      if (f > S(0)) {
        low = theta;
        f_low = f;
        if (side == 1) f_high = f_high / S(2);
        side = 1;
      } else {
        high = theta;
        f_high = f;
        if (side == -1) f_low = f_low / S(2);
        side = -1;
      }
      if (real::abs(f) <= enough) break;
    }
    if (theta < S(1) && theta < first.theta) first = {theta, Condition::calm, static_cast<int>(i)};
  }
}

template <class S> bool stays_clear_of_ends(Flow<S>& flow, Fall<S>& first) {
  EventRun<S>& run = flow.run;
  if (run.ends.empty()) return true;
  const S until = real::min(first.theta, S(1));
  const bool whole = until >= S(1);
  const int looks = passes_a_sheet(run, run.y.data(), run.y_new.data()) ? 32 : 1;
  for (int k = 1; k <= looks; ++k) {
    const S* y = k == looks ? (whole ? run.y_new.data() : flow.at(until)) : flow.at(until * S(k) / S(looks));
    if (!clear_of_ends(run, y))
      return locate_overlap(flow, until * S(k - 1) / S(looks), until * S(k) / S(looks), first);
  }
  return true;
}

#define ATWOOD_FALL(S)                                  \
  template void earliest_touch<S>(Flow<S>&, Fall<S>&);  \
  template void earliest_switch<S>(Flow<S>&, Fall<S>&); \
  template void earliest_calm<S>(Flow<S>&, Fall<S>&);   \
  template bool stays_clear_of_ends<S>(Flow<S>&, Fall<S>&);
ATWOOD_FALL(float)
ATWOOD_FALL(double)
ATWOOD_FALL(long double)
#undef ATWOOD_FALL

}  // namespace atwood::event
