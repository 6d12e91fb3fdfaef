// One step of `+event`.
//
//   trial step       to the end of the step, or as far as error control and slip allow
//   event location   finds the first zero of a switching function within the trial step; trial steps of shorter length
//                    are taken from the same state
//   event            impacts, or a change of the active set, at that state
//   remainder        the same from the event to the end of the step
#include "contact/event/step.hpp"

#include <algorithm>

#include "contact/event/contact_forces.hpp"
#include "contact/event/contact_update.hpp"
#include "contact/event/edge_candidates.hpp"
#include "contact/event/event_location.hpp"
#include "contact/event/flat_ends.hpp"
#include "contact/event/impacts.hpp"
#include "contact/event/painleve.hpp"
#include "contact/event/projection.hpp"
#include "contact/event/slip_step.hpp"
#include "contact/event/surface_boundaries.hpp"

namespace atwood::event {

namespace {

// A run may take at most kMaxEventsWithoutProgress events at one instant, and at most kMaxSegments segments that end
// without an impact while its time advances by less than kMinProgressOfAStep of a step. Impacts at distinct instants
// have no limit: between bodies that nearly touch there may be millions in a step.
constexpr int kMaxEventsWithoutProgress = 10000, kMaxSegments = 100000;
constexpr double kMinProgressOfAStep = 1e-3;
constexpr int kMaxFacetChanges = 1000;  // in a step; a ball that rolls over a mesh changes its facet a few times
constexpr int kMaxSegmentsNearSingularity = 5000;  // each segment changes a Delassus element by at most an eighth
constexpr const char* kSingularSlip =
    "a contact slips towards a singular configuration (Painleve), where its normal force would be infinite";
constexpr const char* kUnsolvedSlip =
    "the implicit equations of a step with contacts were not solved, however short the step was: the contact forces of "
    "its stages do not depend on the state continuously (an explicit method has no such equations)";

// Time left in the step when time last advanced, the number of events and segments since then, and the facet changes of
// the whole step.
template <class S> struct StepProgress {
  S left_at_event_s, left_at_segment_s;
  int events = 0, segments = 0, facet_changes = 0;

  // Count an event or a segment. True: too many without progress of the time.
  bool is_stalled_at_event(S left_s, S round_off_s) {
    if (left_at_event_s - left_s > round_off_s) {
      left_at_event_s = left_s;
      events = 0;
    }
    return ++events > kMaxEventsWithoutProgress;
  }
  bool stalls_at_segment(S left_s, S fraction_s) {
    if (left_at_segment_s - left_s > fraction_s) {
      left_at_segment_s = left_s;
      segments = 0;
    }
    return ++segments > kMaxSegments;
  }
};

template <class S> Stepper<S>& stepper_of(const ActiveSet<S>& active, const Integration<S>& integration) {
  if (active.count > 0 && integration.use_fine_stepper && integration.rtol <= S(0)) return *integration.fine_stepper;
  return active.count > 0 && integration.contact_stepper ? *integration.contact_stepper : integration.stepper;
}

// One trial step from states.y to states.y_new, of at most h_s, which error control may shorten. False: an implicit
// step has no solution, or the error stays too large (the report says so).
template <class S>
bool trial_step(ActiveSet<S>& active, Integration<S>& integration, StateBuffers<S>& states, Report& report,
                Stepper<S>& stepper, S t_s, S& h_s) {
  constexpr int max_rejections = 60;
  active.force_near_bound = false;
  if (integration.rtol <= S(0))
    return take_step(active, integration, stepper, t_s, h_s, states.y.data(), states.overwrite(states.y_new));
  if (integration.h_next_s > S(0) && integration.h_next_s < h_s) h_s = integration.h_next_s;
  for (int i = 0; i < max_rejections; ++i) {
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
  return diverged_at(report, static_cast<double>(t_s),
                     "error control rejected " + std::to_string(max_rejections) + " trial steps in a row");
}

// A trial step, halved until the forces near a singular configuration are resolved (painleve.hpp) and, with contacts,
// until an implicit step has a solution: forces at stages beyond that configuration, or beyond the reversal of a slip,
// are those of another motion, and the stage equations need not have one. False: there is none without contacts, or 60
// halvings did not do.
template <class S> bool resolved_trial_step(EventRun<S>& run, Stepper<S>& stepper, S t_s, S& h_s) {
  constexpr int max_halvings = 60;
  bool solved = true;
  for (int halving = 0; halving < max_halvings; ++halving, h_s = h_s / S(2)) {
    reset_delassus_range(run.active);
    solved = trial_step(run.active, run.integration, run.states, run.report, stepper, t_s, h_s);
    if (!solved && (run.active.count == 0 || run.report.outcome.status != Status::ok)) return false;
    if (solved && (run.active.count == 0 || delassus_is_resolved(run.bodies, run.proximity, run.active))) {
      run.bodies.model.system().solvers.refused = {};
      return true;
    }
  }
  return refuse_at(run.report, static_cast<double>(t_s), solved ? kSingularSlip : kUnsolvedSlip);
}

// Of kMaxEventsWithoutProgress events at one instant. Where a slip dies out at a point beside another that touches, as
// of a board on its edge near a Painleve configuration, the direction of friction turns at once and each point's impact
// lifts the other: the response has no rule for that motion.
template <class S> bool refuse_stall(EventRun<S>& run, S t_s) {
  const bool friction =
      std::any_of(run.active.contacts.begin(), run.active.contacts.end(), [&](const Contact<S>& contact) {
        return run.proximity.pairs[run.proximity.candidates[contact.candidate].pair].friction > S(0);
      });
  if (!friction) return diverged_at(run.report, static_cast<double>(t_s), "10000 events at one instant");
  return refuse_at(run.report, static_cast<double>(t_s),
                   "10000 impacts and changes of contact at one instant: contacts with friction release and meet again "
                   "without the time advancing");
}

// Finds the active set at states.y, projects onto its constraints, and applies an impact without collision if there is
// no contact force. Changes states.y, active, constraints. False: the run ends.
template <class S> bool renew_active_set(EventRun<S>& run, S t_s) {
  if (!update_active_set(run, t_s)) return false;
  run.impacts.points.clear();
  if (!refuse_flat_ends(run, t_s)) return false;
  project_contacts(run.bodies, run.proximity, run.active, run.constraints, run.states);
  return run.active.inconsistent < 0 || impact_without_collision(run, t_s);
}

// Impacts, or the change of contact mode that the crossing stands for, at states.y. Changes velocities in states.y, and
// the active set. False: the run ends.
template <class S> bool handle_event(EventRun<S>& run, const Crossing<S>& crossing, S t_s) {
  if (crossing.function == SwitchingFunction::gap) return resolve_impacts(run, t_s);
  if (crossing.function == SwitchingFunction::zero_wind) return true;
  // Projection may have dropped contacts since the crossing was found, though never an active one.
  std::vector<Contact<S>>& contacts = run.active.contacts;
  const auto found = std::find_if(contacts.begin(), contacts.end(),
                                  [&](const Contact<S>& contact) { return contact.candidate == crossing.index; });
  if (crossing.function == SwitchingFunction::reactivation || found == contacts.end())
    return renew_active_set(run, t_s);
  Contact<S>& contact = *found;
  if (crossing.function == SwitchingFunction::friction_cone) {
    run.bodies.model.system().rate(t_s, run.states.y.data(), run.states.dydt.data());
    release_friction(run.proximity, run.active, contact);
  }
  if (crossing.function == SwitchingFunction::rolling_bound) {
    run.bodies.model.system().rate(t_s, run.states.y.data(), run.states.dydt.data());
    contact.reached_rolling_bound = true;
    contact.rolling = RollingMode::roll;
    contact.roll_direction = (S(-1) / norm(contact.couple_N_m)) * contact.couple_N_m;
  }
  if (crossing.function == SwitchingFunction::facet) {
    update_active_kinematics(run.bodies, run.proximity, run.active, run.states.y.data(), run.states.y.version);
    if (!change_facet(run, contact)) return false;
    // The edge comes to lie on a face. Its present contact is one of the points of that impact.
    if (run.proximity.candidates[contact.candidate].feature.edge && !contact.left_facet)
      return resolve_impacts(run, t_s);
  }
  return renew_active_set(run, t_s);
}

// Do two bodies overlap at states.y so that two opposite normals serve as well? Sets the poses of both.
template <class S> bool has_no_normal(EventRun<S>& run, const Candidate<S>& candidate) {
  Bodies<S>& bodies = run.bodies;
  const Surface<S>& surface = run.proximity.surfaces[candidate.surface];
  const S tiny = bodies.gap_round_off();
  if (candidate.gap > tiny || surface.kind == SurfaceKind::plane || candidate.feature.edge) return false;
  if (surface.kind == SurfaceKind::point || surface.kind == SurfaceKind::segment)
    return candidate.gap + candidate.feature.radius + surface.radius <= tiny;
  if (surface.kind != SurfaceKind::slab) return false;
  update_poses(bodies, candidate, run.states.y.data());
  S outside_m{};
  const Facet<S> facet = facet_below(bodies, run.proximity, candidate, outside_m);
  const Pose<S>&of = bodies.poses[candidate.feature_body], &on = bodies.poses[candidate.surface_body];
  // facet_below() takes the side of the body's centre.
  return facet.dimension == 2 && real::abs(dot(facet.direction_B, to_body(on, of.p - on.p))) <= tiny;
}

// After a change of the equations of motion, and at the start: finds which bodies move, near pairs, impacts at t_s, and
// the active set. False: the run ends.
template <class S> bool restart_contacts(EventRun<S>& run, S t_s) {
  std::fill(run.bodies.moves.begin(), run.bodies.moves.end(), static_cast<unsigned char>(0));
  for (const int body : run.bodies.model.moving()) run.bodies.moves[body] = 1;
  ++run.bodies.moves_version;  // poses, decoupled contacts and factors are no longer valid
  run.bodies.poses_version = 0;
  update_speed_scale(run.bodies, run.states.y.data());
  run.states.y_new = run.states.y;
  for (ShapePair<S>& pair : run.proximity.pairs) pair.travel_until_recheck = S(0);
  ++run.proximity.segment;
  if (!find_near(run.bodies, run.proximity, run.states, run.report, S(0))) return false;
  add_crossing_edges(run);
  if (run.active.is_first_step) {
    run.active.is_first_step = false;
    bool approach = false;
    measure_gaps(run.bodies, run.proximity, run.states);
    for (const int p : run.proximity.near) {
      ShapePair<S>& pair = run.proximity.pairs[p];
      for (int f = pair.first; f < pair.first + pair.count; ++f) {
        const Candidate<S>& candidate = run.proximity.candidates[f];
        approach = approach ||
                   (candidate.gap <= run.bodies.gap_round_off() && candidate.rate < -run.bodies.approach_round_off());
        pair.overlaps_at_start = pair.overlaps_at_start || candidate.gap < -run.bodies.gap_round_off();
        if (has_no_normal(run, candidate))
          return refuse_at(run.report, static_cast<double>(t_s),
                           pair.names + " overlap symmetrically: the contact normal is not unique");
      }
    }
    if (approach) return resolve_impacts(run, t_s);
  }
  return renew_active_set(run, t_s);
}

// The first crossing within the trial step that `flow` was taken for. Changes proximity.near and candidates' gaps, and
// states.y_probe. False: the run ends.
template <class S> bool locate_event(Flow<S>& flow, Crossing<S>& first) {
  EventRun<S>& run = flow.run;
  if (!find_near(run.bodies, run.proximity, run.states, run.report, flow.h_s)) return false;
  measure_gaps(run.bodies, run.proximity, run.states);
  locate_impact(flow, first);
  if (run.active.count > 0) locate_mode_change(flow, first);
  if (!run.drag_bodies.empty()) locate_zero_wind(flow, first);
  return flow.ok && check_boundaries(flow, first) && check_other_facets(flow, first) && check_flat_ends(flow, first);
}

// A trial step and the first crossing within it: both are taken again with half the length where a shorter step of the
// flow has no solution although the whole one has. False: the run ends.
template <class S>
bool trial_step_with_event(EventRun<S>& run, Stepper<S>& stepper, S t_s, S& h_s, Crossing<S>& first) {
  constexpr int max_halvings = 60;
  for (int halving = 0; halving < max_halvings; ++halving, h_s = h_s / S(2)) {
    if (!resolved_trial_step(run, stepper, t_s, h_s)) return false;
    Flow<S> flow{run, stepper, t_s, h_s};
    first = {};
    bool located = locate_event(flow, first);
    if (located && first.theta > S(0) && first.function != SwitchingFunction::none) {
      flow.at(first.theta);
      located = flow.ok;
    }
    if (located || flow.ok || run.active.count == 0) return located;
    run.report.outcome = {};  // of a state that is none
  }
  return refuse_at(run.report, static_cast<double>(t_s), kUnsolvedSlip);
}

// Makes `reached` the present state; the two are swapped, so `reached` receives the former one. Changes states, scales
// of round-off, and the contacts' constraints and directions.
template <class S> void advance_to(EventRun<S>& run, State<S>& reached) {
  run.states.y.swap(reached);
  update_speed_scale(run.bodies, run.states.y.data());
  maintain_contacts(run.bodies, run.proximity, run.active, run.constraints, run.states,
                    run.integration.use_fine_stepper);
}

// False: the time no longer advances, or slip runs into a singular configuration; the run ends.
template <class S> bool check_progress(EventRun<S>& run, StepProgress<S>& progress, S t_s, S h_s, S left_s) {
  if (progress.stalls_at_segment(left_s, S(kMinProgressOfAStep) * h_s))
    return diverged_at(run.report, static_cast<double>(t_s),
                       "slip changes so fast that 100000 segments cover less than a thousandth of a step");
  if (progress.segments > kMaxSegmentsNearSingularity && run.active.count > 0 &&
      near_singularity(run.bodies, run.proximity, run.active))
    return refuse_at(run.report, static_cast<double>(t_s), kSingularSlip);
  return true;
}

}  // namespace

template <class S> bool step_with_events(EventRun<S>& run, S t_s, S h_s) {
  const S round_off_s = S(4) * real::epsilon<S>() * real::abs(t_s + h_s);  // what is left of a step below it is none
  S left_s = h_s;
  StepProgress<S> progress{left_s, left_s};
  for (;;) {
    if (!check_progress(run, progress, t_s, h_s, left_s)) return false;
    if (run.active.active_set_epoch != run.bodies.model.system().epoch) {
      if (!restart_contacts(run, t_s)) return false;
      ++run.proximity.segment;
    }
    S step_s = run.active.count > 0 ? slip_limited_step(run, t_s, h_s, left_s) : left_s;
    Stepper<S>& stepper = stepper_of(run.active, run.integration);
    Crossing<S> first;
    if (!trial_step_with_event(run, stepper, t_s, step_s, first)) return false;
    advance_path_lengths(run.proximity);

    if (first.function == SwitchingFunction::none) {
      shift_gaps(run.proximity);
      advance_to(run, run.states.y_new);
      left_s -= step_s;
      t_s += step_s;
      if (!(left_s > round_off_s)) return true;
      continue;
    }
    if (first.theta > S(0)) {
      advance_to(run, run.states.y_probe);
      t_s += first.theta * step_s;
      left_s -= first.theta * step_s;
    }
    if (!handle_event(run, first, t_s)) return false;
    ++run.proximity.segment;
    if (first.function == SwitchingFunction::gap) --progress.segments;
    if (!(left_s > round_off_s)) return true;
    if (first.function == SwitchingFunction::facet && ++progress.facet_changes > kMaxFacetChanges)
      return refuse_at(run.report, static_cast<double>(t_s),
                       "a contact changed its facet more than 1000 times within a step: it stays on the common edge of "
                       "two facets, and round-off decides on which of them it is");
    if (progress.is_stalled_at_event(left_s, real::epsilon<S>() * real::abs(t_s))) return refuse_stall(run, t_s);
  }
}

#define ATWOOD_STEP(S) template bool step_with_events<S>(EventRun<S>&, S, S);
ATWOOD_STEP(float)
ATWOOD_STEP(double)
ATWOOD_STEP(long double)
#undef ATWOOD_STEP

}  // namespace atwood::event
