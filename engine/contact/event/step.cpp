// One step of `+event`.
//
// A trial step is taken whole. Each condition that must stay positive within it (gaps, normal forces, the way to a
// cone's edge, slip that must not reverse) is looked at on its end; the first that fell is located, theta in (0, 1], by
// shorter steps from the same state, not by interpolation, so an event is as accurate as the method. The step is cut
// there, the event dealt with, and the rest of the step follows.
#include <algorithm>

#include "contact/event/step.hpp"

#include "contact/event/contact_forces.hpp"
#include "contact/event/contact_update.hpp"
#include "contact/event/event_location.hpp"
#include "contact/event/impacts.hpp"
#include "contact/event/painleve.hpp"
#include "contact/event/projection.hpp"
#include "contact/event/slip_step.hpp"
#include "contact/event/surface_boundaries.hpp"

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

template <class S> Stepper<S>& stepper_of(const ActiveSet<S>& active, const Integration<S>& integration) {
  if (active.count > 0 && integration.use_fine_stepper && integration.rtol <= S(0)) return *integration.fine_stepper;
  return active.count > 0 && integration.contact_stepper ? *integration.contact_stepper : integration.stepper;
}

// One trial step from run.states.y into run.states.y_new, as long as error control allows: at most `h_s`, which it may shorten.
template <class S>
bool trial_step(ActiveSet<S>& active, Integration<S>& integration, StateBuffers<S>& states, Stepper<S>& stepper, S t_s,
                S& h_s) {
  active.bound_approached = false;
  if (integration.rtol <= S(0))
    return take_step(active, integration, stepper, t_s, h_s, states.y.data(), states.overwrite(states.y_new));
  if (integration.h_next_s > S(0) && integration.h_next_s < h_s) h_s = integration.h_next_s;
  for (int i = 0; i < 60; ++i) {
    if (!stepper.step(t_s, h_s, states.y.data(), states.overwrite(states.y_new))) return false;
    if (stepper.chooses_steps()) {
      const auto advice = stepper.advise(integration.rtol, integration.atol);
      if (advice.accepted) {
        integration.h_next_s = advice.next_s;
        return true;
      }
      h_s = real::min(advice.next_s, S(0.9) * h_s);
      continue;
    }
    const S error = stepper.error_norm(integration.rtol, integration.atol);
    const S factor = error > S(0) ? S(0.9) / real::sqrt(real::sqrt(error)) : S(5);  // order 4 estimate, damped
    if (error <= S(1)) {
      integration.h_next_s = h_s * real::min(S(5), real::max(S(0.2), factor));
      return true;
    }
    h_s = h_s * real::max(S(0.2), real::min(factor, S(0.9)));
  }
  return false;
}

// ... shortened until forces next to a configuration without any (painleve.cpp) are followed.
template <class S> bool resolved_trial_step(EventRun<S>& run, Stepper<S>& stepper, S t_s, S& h_s) {
  constexpr int most_halvings = 60;
  for (int halving = 0; halving < most_halvings; ++halving, h_s = h_s / S(2)) {
    reset_delassus_range(run.active);
    if (!trial_step(run.active, run.integration, run.states, stepper, t_s, h_s)) return false;
    if (run.active.count == 0 || delassus_is_resolved(run.bodies, run.proximity, run.active)) return true;
  }
  return refuse_at(run.report, static_cast<double>(t_s), kIntoSingularity);
}

// The active set at states.y, projection onto its constraints, and the impact without collision that may follow.
template <class S> bool renew_active_set(EventRun<S>& run, S t_s) {
  if (!update_active_set(run, t_s, true)) return false;
  project_contacts(run.bodies, run.proximity, run.active, run.constraints, run.states);
  return run.active.inconsistent < 0 || impact_without_collision(run, t_s);
}

template <class S> bool handle_event(EventRun<S>& run, const Crossing<S>& crossing, S t_s) {
  if (crossing.function == Switch::gap) return resolve_impacts(run, t_s);
  if (crossing.function == Switch::zero_wind) return true;
  // Projection may have dropped contacts since the crossing was found, though never an active one.
  std::vector<Contact<S>>& contacts = run.active.contacts;
  const auto found = std::find_if(contacts.begin(), contacts.end(),
                                  [&](const Contact<S>& contact) { return contact.candidate == crossing.index; });
  if (crossing.function == Switch::reactivation || found == contacts.end()) return renew_active_set(run, t_s);
  Contact<S>& contact = *found;
  if (crossing.function == Switch::friction_cone) {
    run.bodies.model.system().rate(t_s, run.states.y.data(), run.states.dydt.data());
    release_friction(run.proximity, run.active, contact);
  }
  if (crossing.function == Switch::rolling_bound) {
    run.bodies.model.system().rate(t_s, run.states.y.data(), run.states.dydt.data());
    contact.reached_rolling_bound = true;
    contact.rolling = RollingMode::roll;
    contact.roll_direction = (S(-1) / norm(contact.couple_N_m)) * contact.couple_N_m;
  }
  if (crossing.function == Switch::facet) {
    update_active_kinematics(run.bodies, run.proximity, run.active, run.states.y.data(), run.states.y.version);
    if (!change_facet(run.bodies, run.proximity, run.report, contact)) return false;
  }
  return renew_active_set(run, t_s);
}

// The law has changed, or the run begins: which bodies move, what contacts_on_body, what is pressed on what.
template <class S> bool rebuild_contacts(EventRun<S>& run, S t_s) {
  std::fill(run.bodies.moves.begin(), run.bodies.moves.end(), static_cast<unsigned char>(0));
  for (const int body : run.bodies.model.moving()) run.bodies.moves[body] = 1;
  ++run.bodies.moves_version;  // poses, decoupled contacts and factors are no longer valid
  run.bodies.poses_at = 0;
  update_speed_scale(run.bodies, run.states.y.data());
  run.states.y_new = run.states.y;
  for (ShapePair<S>& pair : run.proximity.pairs) pair.recheck_travel = S(0);
  ++run.proximity.piece;
  if (!find_near(run.bodies, run.proximity, run.states, run.report, S(0))) return false;
  if (run.active.starts) {
    run.active.starts = false;
    bool approach = false;
    measure_gaps(run.bodies, run.proximity, run.states);
    for (const int p : run.proximity.near)
      for (int f = run.proximity.pairs[p].first; f < run.proximity.pairs[p].first + run.proximity.pairs[p].count; ++f)
        approach = approach || (run.proximity.candidates[f].gap <= run.bodies.gap_round_off() &&
                                run.proximity.candidates[f].rate < -run.bodies.approach_round_off());
    if (approach) return resolve_impacts(run, t_s);
  }
  return renew_active_set(run, t_s);
}

}  // namespace

template <class S> bool step_with_events(EventRun<S>& run, S t_s, S h_s) {
  const S round_off_s = S(4) * real::epsilon<S>() * real::abs(t_s + h_s);  // of the step's ends: no step of its own
  S left_s = h_s;
  Progress<S> progress{left_s, left_s};
  for (;;) {
    if (progress.stalls_at_piece(left_s, S(kPartOfAStep) * h_s))
      return diverged_at(run.report, static_cast<double>(t_s),
                         "slip asked for 100000 pieces of a thousandth of a step");
    if (progress.pieces > kMostPiecesNearSingularity && run.active.count > 0 &&
        near_singularity(run.bodies, run.proximity, run.active))
      return refuse_at(run.report, static_cast<double>(t_s), kIntoSingularity);
    if (run.active.reviewed_epoch != run.bodies.model.system().epoch) {
      if (!rebuild_contacts(run, t_s)) return false;
      ++run.proximity.piece;
    }
    S step_s = left_s;
    if (run.active.count > 0) step_s = slip_limited_step(run, t_s, h_s, left_s);
    Stepper<S>& stepper = stepper_of(run.active, run.integration);
    if (!resolved_trial_step(run, stepper, t_s, step_s)) return false;
    if (!find_near(run.bodies, run.proximity, run.states, run.report, step_s)) return false;
    measure_gaps(run.bodies, run.proximity, run.states);
    Flow<S> flow{run, stepper, t_s, step_s};
    Crossing<S> first;
    locate_impact(flow, first);
    if (run.active.count > 0) locate_mode_change(flow, first);
    if (!run.drag_bodies.empty()) locate_zero_wind(flow, first);
    if (!flow.ok || !stays_clear_of_boundaries(flow, real::min(first.theta, S(1)))) return false;
    advance_travel(run.proximity);
    if (first.function == Switch::none) {
      run.states.y.swap(run.states.y_new);
      shift_gaps(run.proximity);
      update_speed_scale(run.bodies, run.states.y.data());
      maintain_contacts(run.bodies, run.proximity, run.active, run.constraints, run.states,
                        run.integration.use_fine_stepper);
      left_s -= step_s;
      t_s += step_s;
      if (!(left_s > round_off_s)) return true;
      continue;
    }
    if (first.theta > S(0)) {
      flow.at(first.theta);
      if (!flow.ok) return false;
      run.states.y.swap(run.states.y_probe);
      t_s += first.theta * step_s;
      left_s -= first.theta * step_s;
      update_speed_scale(run.bodies, run.states.y.data());
      maintain_contacts(run.bodies, run.proximity, run.active, run.constraints, run.states,
                        run.integration.use_fine_stepper);
    }
    if (!handle_event(run, first, t_s)) return false;
    ++run.proximity.piece;
    if (!(left_s > round_off_s)) return true;
    if (progress.stalls_at_event(left_s, real::epsilon<S>() * real::abs(t_s)))
      return diverged_at(run.report, static_cast<double>(t_s),
                         "10000 events followed each other within the last place of the time");
  }
}

#define ATWOOD_STEP(S) template bool step_with_events<S>(EventRun<S>&, S, S);
ATWOOD_STEP(float)
ATWOOD_STEP(double)
ATWOOD_STEP(long double)
#undef ATWOOD_STEP

}  // namespace atwood::event
