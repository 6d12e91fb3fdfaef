// One step of `+event`.
//
// A trial step is taken whole. Each condition that must stay positive within it (gaps, normal forces, the way to a cone's edge, slip
// that must not reverse) is looked at on its end; the first that fell is located, theta in (0, 1], by shorter steps from the same
// state, not by interpolation, so an event is as accurate as the method. The step is cut there, the event dealt with, and the
// rest of the step follows.
#include <algorithm>
#include <cmath>

#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

constexpr int most_events_a_step = 1000, most_pieces_of_a_step = 100000;

enum class Condition : unsigned char { none, gap, force, cone, slip, couple, roll, facet, calm };

template <class S> struct Fall {
  S theta = S(2);
  Condition condition = Condition::none;
  int index = -1;  // feature, contact or wind
};

// A run's probe: the state after theta h.
template <class S> struct Flow {
  EventRun<S>& run;
  Stepper<S>& stepper;
  S t_s, h_s;
  bool ok = true;

  const S* at(S theta) {
    ok = stepper.step(t_s, theta * h_s, run.y.data(), run.y_probe.data()) && ok;
    return run.y_probe.data();
  }
};

// ---- impacts ----------------------------------------------------------------------------------------------------------------
// Newton on the gap, kept inside a bracket: gap(low) > 0 >= gap(high).
template <class S> S refine(Flow<S>& flow, const Feature<S>& feature, S low, S high) {
  S theta = high, best = high;
  for (int i = 0; i < 100; ++i) {
    const Sight<S> sight = sight_of(flow.run, feature, flow.at(theta));
    const S slope = sight.rate * flow.h_s;
    best = theta;
    if (sight.gap > S(0)) low = theta; else high = theta;
    S next = slope < S(0) ? theta - sight.gap / slope : low;
    if (!(next > low && next < high)) next = low + (high - low) / S(2);
    if (real::abs(next - theta) <= real::epsilon<S>() * theta || high - low <= real::epsilon<S>() * high) break;
    theta = next;
  }
  return best;
}

// Where in (0, high) the approach begins: the largest known theta with a positive gap and a falling one after it.
// After an impact the gap starts at zero and rises; half the flight that its first curvature predicts is inside the
// flight, or is halved until it is.
template <class S> S bracket_start(Flow<S>& flow, const Feature<S>& feature, S high) {
  if (feature.gap > S(0) && feature.rate <= S(0)) return S(0);
  const S rate_end = sight_of(flow.run, feature, flow.at(high)).rate * flow.h_s;
  const S fall = feature.rate * flow.h_s - rate_end;
  S theta = fall > S(0) ? feature.rate * flow.h_s / fall * high : high / S(2);
  for (int i = 0; i < 60; ++i) {
    if (sight_of(flow.run, feature, flow.at(theta)).gap > S(0)) return theta;
    theta = theta / S(2);
  }
  return S(0);
}

// The end of the first part of [0, 1] in which the gap falls below zero; above 1 if there is none. A dip inside the step shows as
// a gap that falls at the start and rises at the end: its lowest point is sought by the sign of the rate.
template <class S> S overlap_within(Flow<S>& flow, const Feature<S>& feature) {
  const S none = S(2);
  if (feature.gap_end < S(0)) return feature.gap <= S(0) && feature.rate_end >= S(0) && feature.gap_end >= feature.gap ? none : S(1);
  if (!(feature.rate < S(0) && feature.rate_end > S(0))) return none;
  // Bodies that parted at the start of the step, by round-off not at once: no dip, or the touch would be found for ever.
  if (real::abs(feature.gap) <= flow.run.gap_round_off() && feature.rate >= -flow.run.approach_round_off()) return none;
  // A gap that falls and rises again is convex there: it stays above its tangents at both ends.
  const S fall = feature.rate * flow.h_s, rise = feature.rate_end * flow.h_s;
  if (feature.gap + fall * ((feature.gap_end - rise - feature.gap) / (fall - rise)) > S(0)) return none;
  S low = S(0), high = S(1);
  for (int i = 0; i < 60; ++i) {  // bisection on the rate; stops at the first overlap
    const S middle = low + (high - low) / S(2);
    const Sight<S> sight = sight_of(flow.run, feature, flow.at(middle));
    if (sight.gap <= S(0)) return middle;
    if (sight.rate < S(0)) low = middle; else high = middle;
    if (high - low < real::epsilon<S>()) break;
  }
  return none;
}

template <class S> S touch_of(Flow<S>& flow, const Feature<S>& feature) {
  if (feature.gap <= S(0) && feature.rate < -flow.run.approach_round_off()) return S(0);
  const S high = overlap_within(flow, feature);
  if (high > S(1)) return high;
  // Touching and neither approaching nor leaving, by round-off: not an impact.
  if (real::abs(feature.gap) <= flow.run.gap_round_off() && real::abs(feature.gap_end) <= flow.run.gap_round_off() &&
      real::abs(feature.rate_end) <= flow.run.approach_round_off())
    return S(2);
  return refine(flow, feature, bracket_start(flow, feature, high), high);
}

// ---- which pairs to look at -----------------------------------------------------------------------------------------------
// No farther than the hull of the cubic through both ends.
template <class S> S excursion(const EventRun<S>& run, int body, S h_s) {
  const int offset = run.model.offset(body);
  if (offset < 0 || !run.moves[body]) return S(0);
  const S *from = run.y.data() + offset, *to = run.y_new.data() + offset;
  const S end = norm(load3(to + at_position) - load3(from + at_position)) + h_s / S(3) * norm(load3(to + at_velocity));
  return real::max(end, h_s / S(3) * norm(load3(from + at_velocity)));
}

template <class S> Vec3<S> center(const EventRun<S>& run, int body, const S* y) {
  const int offset = run.model.offset(body);
  return offset < 0 ? run.poses[body].p : load3(y + offset);
}

// Between the bounding spheres (or from one to the plane).
template <class S> S clearance(const EventRun<S>& run, const ShapePair<S>& pair, const S* y) {
  if (pair.plane >= 0) {
    const Surface<S>& plane = run.surfaces[pair.plane];
    return dot(plane.normal_W, center(run, pair.plane_is_a ? pair.b : pair.a, y)) - plane.offset - pair.reach;
  }
  return norm(center(run, pair.b, y) - center(run, pair.a, y)) - pair.reach;
}

template <class S> bool refuse_if_near(EventRun<S>& run, const ShapePair<S>& pair, S clear) {
  if (pair.refused.empty() || clear > S(0)) return true;
  run.outcome = {Status::unsupported, pair.refused, 0, 0, {}};
  return false;
}

template <class S> bool find_near(EventRun<S>& run, S h_s) {
  run.near.clear();
  const int count = static_cast<int>(run.pairs.size());
  const bool few = count <= 3;
  if (!few)
    for (std::size_t i = 0; i < run.reach.size(); ++i) run.excursions[i] = excursion(run, static_cast<int>(i), h_s);
  for (int p = 0; p < count; ++p) {
    ShapePair<S>& pair = run.pairs[p];
    if (few && pair.refused.empty()) {
      run.near.push_back(p);
      continue;
    }
    const S so_far = run.travel[pair.a] + run.travel[pair.b];
    const S in_step = few ? excursion(run, pair.a, h_s) + excursion(run, pair.b, h_s) : run.excursions[pair.a] + run.excursions[pair.b];
    if (!few && so_far + in_step < pair.look_again_at) continue;
    const S clear = clearance(run, pair, run.y.data());
    pair.look_again_at = so_far + clear - run.gap_round_off();
    if (in_step < clear - run.gap_round_off()) continue;
    if (!refuse_if_near(run, pair, real::min(clear, clearance(run, pair, run.y_new.data())))) return false;
    if (pair.refused.empty()) run.near.push_back(p);
  }
  return true;
}

template <class S> void advance_travel(EventRun<S>& run, S theta) {
  if (run.pairs.size() <= 3) return;
  (void)theta;  // the whole step's way bounds a part's
  for (std::size_t i = 0; i < run.travel.size(); ++i) run.travel[i] += run.excursions[i];
}

template <class S> void measure_gaps(EventRun<S>& run) {
  for (const int p : run.near) {
    ShapePair<S>& pair = run.pairs[p];
    const bool known = pair.known_at == run.step_count;
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      Feature<S>& feature = run.features[f];
      if (!known) {
        const Sight<S> start = sight_of(run, feature, run.y.data());
        feature.gap = start.gap;
        feature.rate = start.rate;
      }
      const Sight<S> end = sight_of(run, feature, run.y_new.data());
      feature.gap_end = end.gap;
      feature.rate_end = end.rate;
    }
    pair.known_at = run.step_count;
  }
}

// The step's end is the next one's start.
template <class S> void pass_gaps_on(EventRun<S>& run) {
  ++run.step_count;
  for (const int p : run.near) {
    ShapePair<S>& pair = run.pairs[p];
    pair.known_at = run.step_count;
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      run.features[f].gap = run.features[f].gap_end;
      run.features[f].rate = run.features[f].rate_end;
    }
  }
}

template <class S> void earliest_touch(Flow<S>& flow, Fall<S>& first) {
  EventRun<S>& run = flow.run;
  for (const int p : run.near) {
    const ShapePair<S>& pair = run.pairs[p];
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      if (run.features[f].lasting) continue;
      const S theta = touch_of(flow, run.features[f]);
      if (theta <= S(1) && theta < first.theta) first = {theta, Condition::gap, f};
    }
  }
}

// ---- conditions of lasting contacts -----------------------------------------------------------------------------------------
// Forces as of the contact's last evaluation; slips as of the last look at it.
template <class S> S value_of(const EventRun<S>& run, Condition condition, const Contact<S>& contact) {
  const ShapePair<S>& pair = run.pairs[run.features[contact.feature].pair];
  switch (condition) {
    case Condition::force: return contact.normal_N;
    case Condition::cone: return pair.friction * contact.normal_N - norm(contact.friction_N);
    case Condition::couple: return pair.rolling_friction_m * contact.normal_N - norm(contact.couple_N_m);
    case Condition::slip: return dot(contact.u, contact.slip_direction);
    case Condition::facet: return within_facet(run, contact) + run.gap_round_off();  // 0 above inner edges
    default: return dot(contact.w, contact.roll_direction);
  }
}

template <class S> bool about_forces(Condition condition, S) {
  return condition == Condition::force || condition == Condition::cone || condition == Condition::couple;
}

template <class S> bool applies(const EventRun<S>& run, Condition condition, const Contact<S>& contact) {
  switch (condition) {
    case Condition::force: return true;
    case Condition::cone: return contact.mode == Mode::sticks;
    case Condition::couple: return contact.turning == Turning::held;
    case Condition::slip: return contact.mode == Mode::slips && !contact.waits;
    case Condition::facet: return has_ends(run, contact);
    default: return contact.turning == Turning::rolls;
  }
}

// Contacts as they are at (t, y): forces too if asked for.
template <class S> void see_contacts(EventRun<S>& run, S t_s, const S* y, bool forces) {
  if (forces) {
    run.model.system().rate(t_s, y, run.dydt.data());
    return;
  }
  for (const int body : run.contact_bodies) run.poses[body] = pose_of(run, body, y);
  for (Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    const Feature<S>& feature = run.features[contact.feature];
    const Pose<S>&of = run.poses[feature.knob_body], &on = run.poses[feature.surface_body];
    const Sight<S> sight = look(feature.knob, of, run.surfaces[feature.surface], contact.facet, on);
    contact.u = (of.v + cross(of.w, sight.x - of.p)) - (on.v + cross(on.w, sight.x - on.p));
    contact.w = of.w - on.w;
  }
}

// Illinois on a condition's value: positive at low (or unknown there), negative at high.
template <class S> S locate(Flow<S>& flow, Condition condition, int index, S f_low, S f_high, S high) {
  EventRun<S>& run = flow.run;
  const bool forces = about_forces(condition, S(0));
  S low = S(0);
  if (!(f_low > S(0))) return S(0);
  for (int i = 0, side = 0; i < 100 && high - low > real::epsilon<S>() * high; ++i) {
    S theta = (low * f_high - high * f_low) / (f_high - f_low);
    if (!(theta > low && theta < high)) theta = low + (high - low) / S(2);
    if (!(theta > low && theta < high)) break;
    const S* y = flow.at(theta);
    see_contacts(run, flow.t_s + theta * flow.h_s, y, forces);
    const S f = value_of(run, condition, run.contacts[index]);
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

template <class S> void earliest_switch(Flow<S>& flow, Fall<S>& first) {
  EventRun<S>& run = flow.run;
  constexpr Condition of_forces[] = {Condition::force, Condition::cone, Condition::couple}, of_motion[] = {Condition::slip, Condition::roll, Condition::facet};
  const int count = static_cast<int>(run.contacts.size());
  const auto search = [&](Condition condition, bool forces) {
    for (int i = 0; i < count; ++i) {
      if (!run.contacts[i].carries || !applies(run, condition, run.contacts[i])) continue;
      const S until = real::min(first.theta, S(1));
      const S* y = until < S(1) ? flow.at(until) : run.y_new.data();
      see_contacts(run, flow.t_s + until * flow.h_s, y, forces);
      const S end = value_of(run, condition, run.contacts[i]);
      const S tiny = about_forces(condition, S(0)) ? -S(64) * real::epsilon<S>() * run.contacts[i].largest_N : S(0);
      if (!(end < tiny)) continue;
      see_contacts(run, flow.t_s, run.y.data(), forces);
      const S start = value_of(run, condition, run.contacts[i]);
      const S theta = locate(flow, condition, i, start, end, until);
      if (theta <= S(1) && theta < first.theta) first = {theta, condition, i};
    }
  };
  if (run.least_margin < S(0.1)) for (const Condition condition : of_forces) search(condition, true);
  for (const Condition condition : of_motion) {
    const bool any = std::any_of(run.contacts.begin(), run.contacts.end(), [&](const Contact<S>& c) { return c.carries && applies(run, condition, c); });
    if (any) search(condition, false);
  }
}

// ---- the kink of quadratic drag -----------------------------------------------------------------------------------------------
template <class S> Vec3<S> through_air(const EventRun<S>& run, const Wind<S>& wind, const S* y) {
  return load3(y + run.model.offset(wind.body) + at_velocity) - wind.velocity_W;
}

// Where in the step a body's velocity through the air has turned square to what it was at the start. Steps are cut there:
// across the kink of |u| u no method keeps more than third order. False position (Illinois), from the smooth side.
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

// ---- bodies over the end of a sheet -------------------------------------------------------------------------------------------
template <class S> bool stays_clear_of_ends(Flow<S>& flow, S until) {
  EventRun<S>& run = flow.run;
  if (run.ends.empty()) return true;
  const bool whole = until >= S(1);
  const int looks = passes_a_sheet(run, run.y.data(), run.y_new.data()) ? 32 : 1;
  for (int k = 1; k <= looks; ++k) {
    const S* y = k == looks && whole ? run.y_new.data() : flow.at(until * S(k) / S(looks));
    if (!clear_of_ends(run, y)) return false;
  }
  return true;
}

// ---- steps --------------------------------------------------------------------------------------------------------------------
template <class S> Stepper<S>& stepper_of(EventRun<S>& run) { return run.carrying > 0 && run.substitute ? *run.substitute : run.stepper; }

// Across its slip a body feels friction as a damper of rate mu N k / |u|: stiff where slip is slow. Explicit methods are kept stable
// there by steps of at most 2 |u| / (mu N k), which still span the way to a stop. Slip that sets in starts from the floor.
template <class S> S stable_step(const EventRun<S>& run, S h_s) {
  S longest = h_s;
  for (std::size_t i = 0; i < run.contacts.size();) {
    const int pair = run.features[run.contacts[i].feature].pair;
    S speed = S(-1), braking = S(0);
    for (; i < run.contacts.size() && run.features[run.contacts[i].feature].pair == pair; ++i) {
      const Contact<S>& contact = run.contacts[i];
      if (!contact.carries || contact.mode != Mode::slips || contact.waits) continue;
      const Vec3<S> force = contact.normal_N * (-run.pairs[pair].friction * contact.slip_direction);
      braking -= effect_of_load(run, contact, contact.slip_direction, {}, force, {});
      speed = speed < S(0) ? contact.slip_speed : real::min(speed, contact.slip_speed);
    }
    if (speed >= S(0) && braking > S(0)) longest = real::min(longest, real::max(S(2) * speed / braking, h_s * S(0x1p-40)));
  }
  return longest;
}

// Where forces balance nearly as slip sets in, it grows from nothing by far smaller steps than that. Until it is fast enough, it keeps
// its direction within a step: that at the step's end, as an implicit step finds it, so that no damper is felt. Of first order in that
// direction alone. False: some slip slows down.
template <class S> bool slip_sets_in(EventRun<S>& run, S t_s) {
  run.model.system().rate(t_s, run.y.data(), run.dydt.data());
  for (const Contact<S>& contact : run.contacts) {
    if (!contact.carries || contact.mode != Mode::slips || contact.waits) continue;
    const S friction = run.pairs[run.features[contact.feature].pair].friction * contact.normal_N;
    const S braking = -effect_of_load(run, contact, contact.slip_direction, {}, -friction * contact.slip_direction, {});
    if (dot(contact.slip_direction, relative_acceleration(run, contact, run.dydt.data())) < -S(0x1p-10) * braking) return false;
  }
  return true;
}

template <class S> S step_with_slip(EventRun<S>& run, S t_s, S h_s, S left_s) {
  for (Contact<S>& contact : run.contacts) contact.sets_in = false;
  const S stable = stable_step(run, h_s);
  if (stable >= left_s) return left_s;
  if (!slip_sets_in(run, t_s)) return stable;
  for (Contact<S>& contact : run.contacts) contact.sets_in = true;
  const bool moves = std::any_of(run.contacts.begin(), run.contacts.end(), [&](const Contact<S>& c) { return c.slip_speed > run.slip_round_off(); });
  if (!moves) return left_s;  // along what held it until now
  run.free_rate_of(run.free_context, t_s, run.y.data(), run.dydt.data());
  settle_forces(run, run.dydt.data(), S(1) / left_s);
  return left_s;
}

// One trial step from run.y into run.y_new, as long as error control allows: at most `h_s`, which it may shorten.
template <class S> bool trial_step(EventRun<S>& run, Stepper<S>& stepper, S t_s, S& h_s) {
  run.least_margin = S(1);
  if (run.rtol <= S(0)) return stepper.step(t_s, h_s, run.y.data(), run.y_new.data());
  if (run.h_next_s > S(0) && run.h_next_s < h_s) h_s = run.h_next_s;
  for (int i = 0; i < 60; ++i) {
    if (!stepper.step(t_s, h_s, run.y.data(), run.y_new.data())) return false;
    if (stepper.chooses_steps()) {
      const auto advice = stepper.advise(run.rtol, run.atol);
      if (advice.accepted) {
        run.h_next_s = advice.next_s;
        return true;
      }
      h_s = real::min(advice.next_s, S(0.9) * h_s);
      continue;
    }
    const S error = stepper.error_norm(run.rtol, run.atol);
    const S factor = error > S(0) ? S(0.9) / real::sqrt(real::sqrt(error)) : S(5);  // order 4 estimate, damped
    if (error <= S(1)) {
      run.h_next_s = h_s * real::min(S(5), real::max(S(0.2), factor));
      return true;
    }
    h_s = h_s * real::max(S(0.2), real::min(factor, S(0.9)));
  }
  return false;
}

template <class S> void note_speeds(EventRun<S>& run) {
  for (const int body : run.model.moving()) {
    const S* at = run.y.data() + run.model.offset(body);
    S speed = norm(load3(at + at_velocity));
    if (run.model.rotates(body)) speed += run.reach[body] * norm(load3(at + at_body_rate));
    run.speed_scale = real::max(run.speed_scale, speed);
  }
}

// After a step that kept contacts: drift off, directions of slip renewed, contacts that others lifted let go.
template <class S> void keep_contacts(EventRun<S>& run) {
  if (run.contacts.empty()) return;
  project_contacts(run, run.y.data());
  for (Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    const Vec3<S>& n = contact.sight.normal;
    const Vec3<S> slip = contact.u - dot(contact.u, n) * n, roll = contact.w - dot(contact.w, n) * n;
    const S speed = norm(slip), rolling = norm(roll);
    contact.slip_speed = speed;
    contact.roll_speed = rolling;
    if (contact.mode == Mode::slips && speed > run.slip_round_off()) contact.slip_direction = (S(1) / speed) * slip;
    if (contact.turning == Turning::rolls && rolling * run.pairs[run.features[contact.feature].pair].reach > run.slip_round_off())
      contact.roll_direction = (S(1) / rolling) * roll;
  }
  if (run.carrying == static_cast<int>(run.contacts.size())) return;
  std::erase_if(run.contacts, [&](const Contact<S>& contact) {
    if (contact.carries) return false;
    const Sight<S> sight = sight_of(run, run.features[contact.feature], run.y.data());
    if (sight.gap < contact.rest_gap - S(4) * run.gap_round_off()) run.seen_epoch = -1;  // pressed again: look anew
    if (sight.gap <= contact.rest_gap + S(4) * run.gap_round_off()) return false;
    run.features[contact.feature].lasting = false;
    return true;
  });
}

// With a contact go those of its pair that stand at the edge of their cones as well.
template <class S> void give_way(EventRun<S>& run, Contact<S>& first) {
  const int pair = run.features[first.feature].pair;
  const S edge = real::sqrt(real::epsilon<S>());
  for (Contact<S>& contact : run.contacts) {
    if (!contact.carries || contact.mode != Mode::sticks || run.features[contact.feature].pair != pair) continue;
    const S friction = norm(contact.friction_N);
    if (&contact != &first && friction < (S(1) - edge) * run.pairs[pair].friction * contact.normal_N) continue;
    contact.gives_way = contact.waits = true;
    contact.mode = Mode::slips;
    contact.slip_direction = (S(-1) / friction) * contact.friction_N;
  }
}

template <class S> bool respond(EventRun<S>& run, const Fall<S>& fall, S t_s) {
  if (fall.condition == Condition::gap) return resolve_impacts(run, t_s);
  if (fall.condition == Condition::calm) return true;
  Contact<S>& contact = run.contacts[fall.index];
  if (fall.condition == Condition::cone) {
    see_contacts(run, t_s, run.y.data(), true);
    give_way(run, contact);
  }
  if (fall.condition == Condition::couple) {
    see_contacts(run, t_s, run.y.data(), true);
    contact.turns_over = true;
    contact.turning = Turning::rolls;
    contact.roll_direction = (S(-1) / norm(contact.couple_N_m)) * contact.couple_N_m;
  }
  if (fall.condition == Condition::facet) {
    see_contacts(run, t_s, run.y.data(), false);
    if (!leave_facet(run, contact)) return false;
  }
  if (!review_contacts(run, t_s, true)) return false;
  project_contacts(run, run.y.data());
  return true;
}

// The law has changed, or the run begins: which bodies move, what touches, what is pressed on what.
template <class S> bool look_anew(EventRun<S>& run, S t_s) {
  std::fill(run.moves.begin(), run.moves.end(), static_cast<unsigned char>(0));
  for (const int body : run.model.moving()) run.moves[body] = 1;
  note_speeds(run);
  run.y_new = run.y;
  for (ShapePair<S>& pair : run.pairs) pair.look_again_at = S(0);
  ++run.step_count;
  if (!find_near(run, S(0))) return false;
  if (run.starts) {
    run.starts = false;
    bool approach = false;
    measure_gaps(run);
    for (const int p : run.near)
      for (int f = run.pairs[p].first; f < run.pairs[p].first + run.pairs[p].count; ++f)
        approach = approach || (run.features[f].gap <= run.gap_round_off() && run.features[f].rate < -run.approach_round_off());
    if (approach) return resolve_impacts(run, t_s);
  }
  if (!review_contacts(run, t_s, true)) return false;
  project_contacts(run, run.y.data());
  return true;
}

}  // namespace

template <class S> bool step_with_events(EventRun<S>& run, S t_s, S h_s) {
  const S t_end_s = t_s + h_s;
  S left_s = h_s;
  int pieces = 0;
  for (int events = 0; events < most_events_a_step && pieces < most_pieces_of_a_step; ++events, ++pieces) {
    if (run.seen_epoch != run.model.system().epoch) {
      if (!look_anew(run, t_s)) return false;
      ++run.step_count;
    }
    S step_s = left_s;
    Stepper<S>& stepper = stepper_of(run);
    if (run.carrying > 0) step_s = step_with_slip(run, t_s, h_s, left_s);
    if (!trial_step(run, stepper, t_s, step_s)) return false;
    if (!find_near(run, step_s)) return false;
    measure_gaps(run);
    Flow<S> flow{run, stepper, t_s, step_s};
    Fall<S> first;
    earliest_touch(flow, first);
    if (run.carrying > 0) earliest_switch(flow, first);
    if (!run.winds.empty()) earliest_calm(flow, first);
    if (!flow.ok || !stays_clear_of_ends(flow, real::min(first.theta, S(1)))) return false;
    advance_travel(run, real::min(first.theta, S(1)));
    if (first.condition == Condition::none) {
      run.y.swap(run.y_new);
      pass_gaps_on(run);
      note_speeds(run);
      keep_contacts(run);
      left_s -= step_s;
      t_s += step_s;
      if (!(left_s > real::epsilon<S>() * real::abs(t_end_s))) return true;
      --events;
      continue;
    }
    if (first.theta > S(0)) {
      if (!stepper.step(t_s, first.theta * step_s, run.y.data(), run.y_new.data())) return false;
      run.y.swap(run.y_new);
      t_s += first.theta * step_s;
      left_s -= first.theta * step_s;
      note_speeds(run);
      keep_contacts(run);
    }
    if (!respond(run, first, t_s)) return false;
    ++run.step_count;
    if (!(left_s > S(0))) return true;
  }
  run.outcome = {Status::diverged, "atwood's +event met more than 1000 events in one step, or slip that asks for 100000 pieces of it", 0, 0, {}};
  return false;
}

template bool step_with_events<float>(EventRun<float>&, float, float);
template bool step_with_events<double>(EventRun<double>&, double, double);
template bool step_with_events<long double>(EventRun<long double>&, long double, long double);

}  // namespace atwood::event
