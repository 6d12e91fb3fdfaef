// One step of `+event`.
//
// A trial step is taken whole. Each condition that must stay positive within it (gaps, normal forces, the way to a
// cone's edge, slip that must not reverse) is looked at on its end; the first that fell is located, theta in (0, 1], by
// shorter steps from the same state, not by interpolation, so an event is as accurate as the method. The step is cut
// there, the event dealt with, and the rest of the step follows.
#include <algorithm>

#include "contact/event/fall.hpp"

namespace atwood::event {

namespace {

// A run may have as many events as its motion asks for, as long as its time goes on.
constexpr int kMostEventsWithoutProgress = 10000, kMostPiecesOfAPart = 100000;
constexpr double kPartOfAStep = 1e-3;
constexpr int kMostPiecesNearSingularity = 5000;  // each changes what a force gives there by an eighth at most
constexpr const char* kIntoSingularity =
    "a contact slides into a configuration without contact forces (Painleve): its normal force grows without bound";

// Of a step: how much was left of it when its time last went on, and what came since.
template <class S> struct Progress {
  S left_at_event_s, left_at_piece_s;
  int events = 0, pieces = 0;

  // Do events follow each other within the last place of the time?
  bool stalls_at_event(S left_s, S place_s) {
    if (left_at_event_s - left_s > place_s) {
      left_at_event_s = left_s;
      events = 0;
    }
    return ++events > kMostEventsWithoutProgress;
  }
  bool stalls_at_piece(S left_s, S part_s) {
    if (left_at_piece_s - left_s > part_s) {
      left_at_piece_s = left_s;
      pieces = 0;
    }
    return ++pieces > kMostPiecesOfAPart;
  }
};

template <class S> bool diverged(EventRun<S>& run, S t_s, const char* what) {
  run.outcome = {
      Status::diverged, "atwood's +event: at t = " + format_double(static_cast<double>(t_s)) + " s " + what, 0, 0, {}};
  return false;
}

template <class S> Stepper<S>& stepper_of(EventRun<S>& run) {
  if (run.carrying > 0 && run.slip_ends && run.rtol <= S(0)) return *run.fine;
  return run.carrying > 0 && run.substitute ? *run.substitute : run.stepper;
}

// Slip that is round-off yet keeps the direction in which it set in.
template <class S> bool starts_from_rest(const EventRun<S>& run, const Contact<S>& contact) {
  return contact.mode == Mode::slips && !(contact.slip_speed > run.slip_round_off());
}

template <class S> bool slides(const Contact<S>& contact) {
  return contact.carries && contact.mode == Mode::slips && !contact.waits;
}

// Across its slip a body feels friction as a damper of rate mu N k / |u|: stiff where slip is slow. Explicit methods
// are kept stable there by steps of at most 2 |u| / (mu N k), which still span the way to a stop. Slip that sets in
// starts from the floor.
template <class S> S stable_step(const EventRun<S>& run, S h_s) {
  S longest = h_s;
  for (std::size_t i = 0; i < run.contacts.size();) {
    const std::size_t first = i;
    const Feature<S>& feature = run.features[run.contacts[i].feature];
    const S friction = run.pairs[feature.pair].friction;
    S speed = S(-1), loads = S(0);
    for (; i < run.contacts.size() && run.features[run.contacts[i].feature].pair == feature.pair; ++i) {
      const Contact<S>& contact = run.contacts[i];
      if (!slides(contact)) continue;
      loads += contact.normal_N;
      if (starts_from_rest(run, contact)) continue;
      speed = speed < S(0) ? contact.slip_speed : real::min(speed, contact.slip_speed);
    }
    const S most = friction * loads * (run.mobility[feature.knob_body] + run.mobility[feature.surface_body]);
    if (speed < S(0) || S(2) * speed >= longest * most) continue;
    S braking = S(0);
    for (std::size_t k = first; k < i; ++k) {
      const Contact<S>& contact = run.contacts[k];
      if (!slides(contact)) continue;
      const Vec3<S> force = contact.normal_N * (-friction * contact.slip_direction);
      braking -= effect_of_load(run, contact, contact.slip_direction, {}, force, {});
    }
    if (braking > S(0)) longest = real::min(longest, real::max(S(2) * speed / braking, h_s * S(0x1p-40)));
  }
  return longest;
}

// Where forces balance nearly as slip sets in, it grows from nothing by far smaller steps than that. Until it is fast
// enough, it keeps its direction within a step: that at the step's end, as an implicit step finds it, so that no damper
// is felt. Of first order in that direction alone. False: some slip slows down.
template <class S> bool slip_sets_in(EventRun<S>& run, S t_s) {
  run.model.system().rate(t_s, run.y.data(), run.dydt.data());
  for (const Contact<S>& contact : run.contacts) {
    if (!slides(contact)) continue;
    const S friction = run.pairs[run.features[contact.feature].pair].friction * contact.normal_N;
    const S braking = -effect_of_load(run, contact, contact.slip_direction, {}, -friction * contact.slip_direction, {});
    if (dot(contact.slip_direction, relative_acceleration(run, contact, run.dydt.data())) < -S(0x1p-10) * braking)
      return false;
  }
  return true;
}

// The slip of a body that is stopped, or turned round, turns ever faster the slower it is: about speed / braking is
// left for that. In fixed parts of this time such a slip is smooth, down to round-off, and a fixed number of parts
// takes a fixed part of its speed: few enough for a method of order 8. Slip that keeps its direction needs none of
// this.
template <class S> S step_with_slip(EventRun<S>& run, S t_s, S h_s, S left_s) {
  const auto keep_directions = [&](bool keep) {
    for (Contact<S>& contact : run.contacts) contact.sets_in = keep || starts_from_rest(run, contact);
  };
  run.slip_ends = false;
  const S far = S(8) * h_s, stable = stable_step(run, far);
  const bool sets_in = std::any_of(run.contacts.begin(), run.contacts.end(), [&](const Contact<S>& contact) {
    return contact.carries && !contact.waits && starts_from_rest(run, contact);
  });
  if (stable >= far && !sets_in) {
    keep_directions(false);
    return left_s;
  }
  for (Contact<S>& contact : run.contacts) contact.sets_in = contact.sets_in || starts_from_rest(run, contact);
  const bool brakes = !slip_sets_in(run, t_s);  // what keeps its direction does so here
  const SlipTurn turn = slip_turn(run, stable);
  keep_directions(false);
  if (turn.turns && turn.moves && (brakes || !turn.slow)) {
    run.slip_ends = true;
    return real::min(left_s, stable / S(8));
  }
  if (turn.moves && stable >= left_s) return left_s;
  keep_directions(true);
  if (!turn.moves) return turn.slow ? left_s : real::min(left_s, S(0x1p-16) * h_s);  // along what held it until now
  if (!turn.turns) return left_s;
  run.free_rate_of(run.free_context, t_s, run.y.data(), run.dydt.data());
  settle_forces(run, run.dydt.data(), S(1) / left_s);
  return left_s;
}

// One trial step from run.y into run.y_new, as long as error control allows: at most `h_s`, which it may shorten.
template <class S> bool trial_step(EventRun<S>& run, Stepper<S>& stepper, S t_s, S& h_s) {
  run.near_bound = false;
  run.sights_at_end = false;
  if (run.rtol <= S(0)) return take_step(run, stepper, t_s, h_s, run.y.data(), run.y_new.data());
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

// ... shortened until forces next to a configuration without any (painleve.cpp) are followed.
template <class S> bool followed_step(EventRun<S>& run, Stepper<S>& stepper, S t_s, S& h_s) {
  constexpr int most_halvings = 60;
  for (int halving = 0; halving < most_halvings; ++halving, h_s = h_s / S(2)) {
    forget_yields(run);
    if (!trial_step(run, stepper, t_s, h_s)) return false;
    if (run.carrying == 0 || keeps_off_singularity(run)) return true;
  }
  return refuse_at(run, t_s, kIntoSingularity);
}

// The largest |v| + r |w|, whose square is at most 2 (v^2 + r^2 w^2): most steps need no root.
template <class S> void note_speeds(EventRun<S>& run) {
  for (const int body : run.model.moving()) {
    const S* at = run.y.data() + run.model.offset(body);
    const Vec3<S> v = load3(at + kAtVelocity), w = run.model.rotates(body) ? load3(at + kAtBodyRate) : Vec3<S>{};
    const S reach = run.reach[body];
    if (S(2) * (dot(v, v) + reach * reach * dot(w, w)) <= run.speed_scale * run.speed_scale) continue;
    run.speed_scale = real::max(run.speed_scale, norm(v) + reach * norm(w));
  }
}

// What goes on slipping or rolling, and which way now.
template <class S> void renew_directions(EventRun<S>& run, Contact<S>& contact) {
  const Vec3<S>& n = contact.sight.normal;
  if (contact.mode == Mode::slips) {
    const Vec3<S> slip = contact.u - dot(contact.u, n) * n;
    contact.slip_speed = norm(slip);
    const bool moves = contact.slip_speed > run.slip_round_off();
    const Vec3<S> direction = moves ? (S(1) / contact.slip_speed) * slip : contact.slip_direction;
    // In slip that has just set in, so much may come of the forces' round-off.
    const bool same = norm(direction - contact.slip_direction) < S(0x1p-7);
    if (!contact.sets_in || !same) contact.slip_direction = direction;
  }
  if (contact.turning == Turning::rolls) {
    const Vec3<S> roll = contact.w - dot(contact.w, n) * n;
    contact.roll_speed = norm(roll);
    const S reach = run.pairs[run.features[contact.feature].pair].reach;
    if (contact.roll_speed * reach > run.slip_round_off()) contact.roll_direction = (S(1) / contact.roll_speed) * roll;
  }
}

// After a step that kept contacts: drift off, directions of slip renewed, contacts that others lifted let go.
template <class S> void keep_contacts(EventRun<S>& run, bool seen) {
  if (run.contacts.empty()) return;
  keep_shares(run);
  project_contacts(run, run.y.data(), seen);
  for (Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    const bool moved = contact.slip_speed > run.slip_round_off();
    renew_directions(run, contact);
    const bool stopped = moved && !contact.waits && starts_from_rest(run, contact);
    if (run.slip_ends && stopped) run.seen_epoch = -1;
  }
  if (run.carrying == static_cast<int>(run.contacts.size())) return;
  std::erase_if(run.contacts, [&](const Contact<S>& contact) {
    if (contact.carries) return false;
    const Feature<S>& feature = run.features[contact.feature];
    const Sight<S> sight = sight_of(run, feature, run.y.data());
    if (sight.gap < contact.rest_gap - S(4) * run.gap_round_off()) run.seen_epoch = -1;  // pressed again: look anew
    if (sight.gap <= contact.rest_gap + S(4) * run.gap_round_off()) return false;
    run.features[contact.feature].lasting = false;
    run.pairs[feature.pair].known_at = -1;  // lasting contacts' gaps are not measured
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
    run.model.system().rate(t_s, run.y.data(), run.dydt.data());
    give_way(run, contact);
  }
  if (fall.condition == Condition::couple) {
    run.model.system().rate(t_s, run.y.data(), run.dydt.data());
    contact.turns_over = true;
    contact.turning = Turning::rolls;
    contact.roll_direction = (S(-1) / norm(contact.couple_N_m)) * contact.couple_N_m;
  }
  if (fall.condition == Condition::facet) {
    see_contacts(run, run.y.data());
    if (!leave_facet(run, contact)) return false;
  }
  if (!review_contacts(run, t_s, true)) return false;
  project_contacts(run, run.y.data());
  return run.inconsistent < 0 || strike(run, t_s);
}

// The law has changed, or the run begins: which bodies move, what touches, what is pressed on what.
template <class S> bool look_anew(EventRun<S>& run, S t_s) {
  std::fill(run.moves.begin(), run.moves.end(), static_cast<unsigned char>(0));
  for (const int body : run.model.moving()) run.moves[body] = 1;
  run.modes = 0;  // which bodies move has a say in which contacts are alone
  run.has_factors = false;
  note_speeds(run);
  run.y_new = run.y;
  for (ShapePair<S>& pair : run.pairs) pair.look_again_at = S(0);
  ++run.step_count;
  if (!find_near(run, S(0))) return false;
  list_crossing_edges(run, run.y.data());
  if (run.starts) {
    run.starts = false;
    bool approach = false;
    measure_gaps(run);
    for (const int p : run.near)
      for (int f = run.pairs[p].first; f < run.pairs[p].first + run.pairs[p].count; ++f)
        approach = approach ||
                   (run.features[f].gap <= run.gap_round_off() && run.features[f].rate < -run.approach_round_off());
    if (approach) return resolve_impacts(run, t_s);
  }
  if (!review_contacts(run, t_s, true)) return false;
  project_contacts(run, run.y.data());
  return run.inconsistent < 0 || strike(run, t_s);
}

}  // namespace

template <class S> bool step_with_events(EventRun<S>& run, S t_s, S h_s) {
  const S round_off_s = S(4) * real::epsilon<S>() * real::abs(t_s + h_s);  // of the step's ends: no step of its own
  S left_s = h_s;
  Progress<S> progress{left_s, left_s};
  for (;;) {
    if (progress.stalls_at_piece(left_s, S(kPartOfAStep) * h_s))
      return diverged(run, t_s, "slip asked for 100000 pieces of a thousandth of a step");
    if (progress.pieces > kMostPiecesNearSingularity && run.carrying > 0 && near_singularity(run))
      return refuse_at(run, t_s, kIntoSingularity);
    if (run.seen_epoch != run.model.system().epoch) {
      if (!look_anew(run, t_s)) return false;
      ++run.step_count;
    }
    S step_s = left_s;
    if (run.carrying > 0) step_s = step_with_slip(run, t_s, h_s, left_s);
    Stepper<S>& stepper = stepper_of(run);
    if (!followed_step(run, stepper, t_s, step_s)) return false;
    if (!find_near(run, step_s)) return false;
    measure_gaps(run);
    Flow<S> flow{run, stepper, t_s, step_s};
    Fall<S> first;
    earliest_touch(flow, first);
    if (run.carrying > 0) earliest_switch(flow, first);
    if (!run.winds.empty()) earliest_calm(flow, first);
    if (!flow.ok || !stays_clear_of_ends(flow, first)) return false;
    advance_travel(run);
    if (first.condition == Condition::none) {
      run.y.swap(run.y_new);
      pass_gaps_on(run);
      note_speeds(run);
      keep_contacts(run, run.sights_at_end);
      left_s -= step_s;
      t_s += step_s;
      if (!(left_s > round_off_s)) return true;
      continue;
    }
    if (first.theta > S(0)) {
      flow.at(first.theta);
      if (!flow.ok) return false;
      run.y.swap(run.y_probe);
      t_s += first.theta * step_s;
      left_s -= first.theta * step_s;
      note_speeds(run);
      keep_contacts(run, false);
    }
    if (!respond(run, first, t_s)) return false;
    ++run.step_count;
    if (!(left_s > round_off_s)) return true;
    if (progress.stalls_at_event(left_s, real::epsilon<S>() * real::abs(t_s)))
      return diverged(run, t_s, "10000 events followed each other within the last place of the time");
  }
}

template bool step_with_events<float>(EventRun<float>&, float, float);
template bool step_with_events<double>(EventRun<double>&, double, double);
template bool step_with_events<long double>(EventRun<long double>&, long double, long double);

}  // namespace atwood::event
