// The impacts of one instant.
//
// Sequential: the pair that approaches fastest collides (ties within round-off: the first in the scene's order), then
// the next, until no pair approaches; right for touching cradles. Points of one pair that move alike are one point;
// others are solved together. Simultaneous ("together"): all points of all pairs are one complementarity problem
// (impact_problem.hpp).

#include <algorithm>

#include "contact/event/bounces.hpp"
#include "contact/event/edge_candidates.hpp"
#include "contact/event/flat_ends.hpp"
#include "contact/event/painleve.hpp"
#include "contact/event/projection.hpp"
#include "contact/event/surface_boundaries.hpp"

namespace atwood::event {

namespace {

// Impacts one after another come to an end of their own, with e < 1 geometrically; a run with more ends.
constexpr int kMaxImpacts = 1000000;

// Bodies move away from where they began, and the round-off of a gap grows with their coordinates.
template <class S>
void update_length_scale(Bodies<S>& bodies, const Proximity<S>& proximity, const StateBuffers<S>& states) {
  for (const int p : proximity.near)
    for (const int body : {proximity.pairs[p].a, proximity.pairs[p].b}) {
      const int offset = bodies.model.offset(body);
      if (offset < 0) continue;
      bodies.length_scale =
          real::max(bodies.length_scale, norm(load3(states.y.data() + offset)) + bodies.bounding_radius[body]);
    }
}

// Gap, rate, normal and point of a contact at states.y. A contact of two edges persists while one of them lies on a
// face, where round-off decides whether they cross.
template <class S>
GapKinematics<S> contact_kinematics(Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact,
                                    const StateBuffers<S>& states) {
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  if (!candidate.feature.edge) return gap_at(bodies, proximity, candidate, states.y.data());
  update_poses(bodies, candidate, states.y.data());
  return held_kinematics(bodies, proximity, contact);
}

template <class S>
void find_impact_points(Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                        Impacts<S>& impacts, const StateBuffers<S>& states) {
  impacts.points.clear();
  for (const int p : proximity.near) {
    const ShapePair<S>& pair = proximity.pairs[p];
    if (!bodies.moves[pair.a] && !bodies.moves[pair.b]) continue;
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      const Candidate<S>& candidate = proximity.candidates[f];
      const auto contact = std::find_if(active.contacts.begin(), active.contacts.end(),
                                        [&](const Contact<S>& c) { return c.candidate == f; });
      const GapKinematics<S> kinematics = contact == active.contacts.end()
                                              ? gap_at(bodies, proximity, candidate, states.y.data())
                                              : contact_kinematics(bodies, proximity, *contact, states);
      if (!(kinematics.gap <= bodies.gap_round_off())) continue;
      if (!candidate.in_contact && kinematics.rate < -bodies.approach_round_off() &&
          leaves_without_impact(bodies, proximity, candidate, kinematics.rate))
        continue;
      ImpactPoint<S> point;
      point.candidate = f;
      point.pair = p;
      point.kinematics = kinematics;
      impacts.points.push_back(point);
    }
  }
  for (const ImpactPoint<S>& point : impacts.points)
    update_poses(bodies, proximity.candidates[point.candidate], states.y.data());
}

template <class S> bool solve_impacts(ImpactProblem<S>& problem) {
  problem.impacts.applied.clear();
  const int count = static_cast<int>(problem.impacts.points.size());
  if (problem.options.simultaneous) {
    if (count == 1) collide_point(problem, problem.impacts.points[0]);
    else if (count > 1 && !(end_of_pair(problem.impacts, 0) == count && collide_as_one_point(problem, 0, count)))
      return collide_simultaneously(problem, 0, count);
    return true;
  }
  for (int impacts = 0; impacts < kMaxImpacts; ++impacts) {
    int fastest = -1;
    S least = S(0);
    for (int i = 0; i < count; ++i) {  // ties within round-off: the first in the scene's order
      const S vn = problem.vn(problem.impacts.points[i]);
      if (vn < least - problem.approach_round_off) {
        least = vn;
        fastest = i;
      }
    }
    if (fastest < 0) return true;
    int first = fastest;
    while (first > 0 && problem.impacts.points[first - 1].pair == problem.impacts.points[fastest].pair) --first;
    const int end = end_of_pair(problem.impacts, first);
    if (end - first == 1) collide_point(problem, problem.impacts.points[first]);
    else if (!collide_as_one_point(problem, first, end - first) && !collide_simultaneously(problem, first, end - first))
      return false;
  }
  problem.report.outcome = {
      Status::diverged, "atwood's +event: 1000000 impacts at one instant did not end the approach", 0, 0, {}};
  return false;
}

// False, and the run ends: a vertex approaches a face and leaves it over its boundary at the same instant, within
// round-off, so that an impact can be neither affirmed nor excluded.
template <class S> bool refuse_leaving_vertices(EventRun<S>& run, S t_s) {
  for (const ImpactPoint<S>& point : run.impacts.points) {
    const Candidate<S>& candidate = run.proximity.candidates[point.candidate];
    if (candidate.in_contact || !(point.kinematics.rate < -run.bodies.approach_round_off())) continue;
    if (leaving_speed(run.bodies, run.proximity, candidate) > S(0))
      return refuse_at(run.report, static_cast<double>(t_s),
                       "whether a vertex hits the edge of a face or passes it is decided by round-off");
  }
  return true;
}

template <class S>
void restore_poses(Bodies<S>& bodies, const Proximity<S>& proximity, const Impacts<S>& impacts,
                   const StateBuffers<S>& states) {
  for (const ImpactPoint<S>& point : impacts.points)
    update_poses(bodies, proximity.candidates[point.candidate], states.y.data());
}

template <class S>
void store_velocities(Bodies<S>& bodies, const Proximity<S>& proximity, const Impacts<S>& impacts,
                      StateBuffers<S>& states) {
  S* y = states.overwrite(states.y);
  for (const ImpactPoint<S>& point : impacts.points)
    for (const int body :
         {proximity.candidates[point.candidate].feature_body, proximity.candidates[point.candidate].surface_body})
      store_velocity(bodies, body, bodies.poses[body].v, bodies.poses[body].w, y);
}

template <class S>
void drop_separated(Bodies<S>& bodies, Proximity<S>& proximity, ActiveSet<S>& active, const StateBuffers<S>& states,
                    S round_off) {
  std::erase_if(active.contacts, [&](const Contact<S>& contact) {
    const GapKinematics<S> kinematics = contact_kinematics(bodies, proximity, contact, states);
    if (!(real::abs(kinematics.rate) > round_off)) return false;
    proximity.candidates[contact.candidate].in_contact = false;
    return true;
  });
}

}  // namespace

template <class S> bool resolve_impacts(EventRun<S>& run, S t_s) {
  update_length_scale(run.bodies, run.proximity, run.states);
  add_crossing_edges(run);
  find_impact_points(run.bodies, run.proximity, run.active, run.impacts, run.states);
  if (!refuse_parallel_edges(run, t_s)) return false;
  if (!refuse_leaving_vertices(run, t_s)) return false;
  if (!refuse_flat_ends(run, t_s)) return false;
  ImpactProblem<S> problem{run.bodies,  run.proximity, run.impacts,
                           run.options, run.report,    run.bodies.approach_round_off()};
  for (const ImpactPoint<S>& point : run.impacts.points) run.proximity.pairs[point.pair].last_bounce = false;
  run.states.y_before_impacts = run.states.y;
  if (!solve_impacts(problem)) return false;
  store_velocities(run.bodies, run.proximity, run.impacts, run.states);
  if (find_last_bounces(run, problem, t_s)) {
    run.states.y = run.states.y_before_impacts;
    restore_poses(run.bodies, run.proximity, run.impacts, run.states);
    if (!solve_impacts(problem)) return false;
    store_velocities(run.bodies, run.proximity, run.impacts, run.states);
  }
  for (const AppliedImpulse<S>& applied : run.impacts.applied)
    if (!applied.impulse.converged) {
      run.report.outcome = {
          Status::diverged,
          "atwood's +event: the slip or rolling during the impact at t = " + format_double(static_cast<double>(t_s)) +
              " s was not resolved: its iteration did not converge",
          0,
          0,
          {}};
      return false;
    }
  for (const AppliedImpulse<S>& applied : run.impacts.applied)
    report_event(run.report, EventKind::impact, run.proximity.pairs[applied.pair], applied.kinematics,
                 applied.feature_is_a, applied.impulse, t_s);
  drop_separated(run.bodies, run.proximity, run.active, run.states, run.bodies.slip_round_off());
  if (!update_active_set(run, t_s)) return false;
  for (std::size_t i = 0; i < run.impacts.applied.size(); ++i) {
    const AppliedImpulse<S>& applied = run.impacts.applied[i];
    ShapePair<S>& pair = run.proximity.pairs[applied.pair];
    const bool again =
        std::any_of(run.impacts.applied.begin(), run.impacts.applied.begin() + static_cast<std::ptrdiff_t>(i),
                    [&](const AppliedImpulse<S>& earlier) { return earlier.pair == applied.pair; });
    const bool lasts = std::any_of(
        run.active.contacts.begin(), run.active.contacts.end(),
        [&](const Contact<S>& contact) { return run.proximity.candidates[contact.candidate].pair == applied.pair; });
    const bool was = std::any_of(
        run.active.previous.begin(), run.active.previous.end(),
        [&](const Contact<S>& contact) { return run.proximity.candidates[contact.candidate].pair == applied.pair; });
    if (!again && lasts && !was)
      report_event(run.report, EventKind::rest, pair, applied.kinematics, applied.feature_is_a, Impulse<S>{},
                   t_s + (pair.last_bounce ? pair.remaining_bounces_s : S(0)));
  }
  for (const AppliedImpulse<S>& applied : run.impacts.applied) run.proximity.pairs[applied.pair].last_bounce = false;
  project_contacts(run.bodies, run.proximity, run.active, run.constraints, run.states);
  return run.active.inconsistent < 0 || impact_without_collision(run, t_s);
}

#define ATWOOD_IMPACTS(S) template bool resolve_impacts<S>(EventRun<S>&, S);
ATWOOD_IMPACTS(float)
ATWOOD_IMPACTS(double)
ATWOOD_IMPACTS(long double)
#undef ATWOOD_IMPACTS

}  // namespace atwood::event
