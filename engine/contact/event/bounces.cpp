#include "contact/event/bounces.hpp"

#include <algorithm>
#include <cmath>

#include "contact/event/contact_forces.hpp"

namespace atwood::event {

namespace {

// Each impact is located to about eps r / v, so late bounces cost more accuracy than they bring: a series is summed as
// soon as a bounce rises by less than eps^(2/3) r.
//   flight                   T_k = 2 v / a
//   rise                     a T_k^2 / 8
//   remainder of the series  T_k / (1 - e)
// The last impact is resolved with e = 0: friction's impulse over the remainder of the series, and the distance it
// takes from a sliding body, are then those of a body that slides under its weight from here on, exactly. Each impact
// predicts when the series will have ended, early ones with less round-off. The earliest prediction that agrees with
// all later ones to round-off is kept.
template <class S>
void predict_last_bounce(const Bodies<S>& bodies, ShapePair<S>& pair, S t_s, S rise_speed, S series_s, S ratio) {
  const S places = norm(bodies.poses[pair.a].p) + norm(bodies.poses[pair.b].p) + pair.bounding_radii;
  const S round_off = S(4) * real::epsilon<S>() * (places / (rise_speed * (S(1) - ratio)) + t_s);
  if (!(real::abs(t_s + series_s - pair.bounces_end_s) <= round_off)) pair.bounces_end_s = t_s + series_s;
}

// The ratio of successive approach speeds: the pair's restitution, unless impacts with other bodies took part.
template <class S>
S ratio_of_bounces(const Proximity<S>& proximity, const Impacts<S>& impacts, int pair, S rise_speed) {
  const auto first =
      std::find_if(impacts.applied.begin(), impacts.applied.end(), [&](const auto& p) { return p.pair == pair; });
  if (impacts.applied.size() == 1 || first == impacts.applied.end()) return proximity.pairs[pair].restitution;
  return rise_speed / -first->impulse.vn_before_m_per_s;
}

// Contacts that separate after the impacts of this instant have no force any more.
template <class S> void deactivate_separating(EventRun<S>& run, const ImpactProblem<S>& problem) {
  for (Contact<S>& contact : run.active.contacts)
    contact.active =
        contact.active &&
        std::none_of(run.impacts.points.begin(), run.impacts.points.end(), [&](const ImpactPoint<S>& point) {
          return point.candidate == contact.candidate && problem.vn(point) > problem.approach_round_off;
        });
  run.active.count = static_cast<int>(
      std::count_if(run.active.contacts.begin(), run.active.contacts.end(), [](const auto& c) { return c.active; }));
}

}  // namespace

template <class S> bool find_last_bounces(EventRun<S>& run, const ImpactProblem<S>& problem, S t_s) {
  bool found = false, known = false;
  for (int first = 0; first < static_cast<int>(run.impacts.points.size()); first = end_of_pair(run.impacts, first)) {
    ShapePair<S>& pair = run.proximity.pairs[run.impacts.points[first].pair];
    if (pair.last_bounce || !(pair.restitution > S(0)) || pair.restitution >= S(1)) continue;
    const int end = end_of_pair(run.impacts, first);
    S rise_speed = -S(1);
    for (int i = first; i < end; ++i) rise_speed = real::max(rise_speed, problem.vn(run.impacts.points[i]));
    const bool collided = std::any_of(run.impacts.applied.begin(), run.impacts.applied.end(),
                                      [&](const auto& p) { return p.pair == run.impacts.points[first].pair; });
    if (!collided || !(rise_speed > S(0))) continue;
    if (!known) {  // accelerations without the contacts of this instant
      known = true;
      deactivate_separating(run, problem);
      evaluate_rates(run, t_s);
    }
    S closing_acceleration = S(0);
    for (int i = first; i < end; ++i) {
      Contact<S> contact;
      contact.candidate = run.impacts.points[i].candidate;
      S outside_m{};
      const Candidate<S>& candidate = run.proximity.candidates[contact.candidate];
      contact.facet = facet_below(run.bodies, run.proximity, candidate, outside_m);
      contact.kinematics = gap_kinematics_with_rates(candidate.feature, run.bodies.poses[candidate.feature_body],
                                                     run.proximity.surfaces[candidate.surface], contact.facet,
                                                     run.bodies.poses[candidate.surface_body]);
      contact.u = problem.u(run.impacts.points[i]);
      closing_acceleration = real::max(
          closing_acceleration, -normal_acceleration(run.bodies, run.proximity, contact, run.states.dydt.data()));
    }
    if (!(closing_acceleration > S(0))) continue;
    const S size_a = run.bodies.bounding_radius[pair.a] > S(0) ? run.bodies.bounding_radius[pair.a]
                                                               : run.bodies.bounding_radius[pair.b];
    const S size =
        run.bodies.bounding_radius[pair.b] > S(0) ? real::min(size_a, run.bodies.bounding_radius[pair.b]) : size_a;
    const S flight = S(2) * rise_speed / closing_acceleration, root = std::cbrt(real::epsilon<S>());
    const S ratio = ratio_of_bounces(run.proximity, run.impacts, run.impacts.points[first].pair, rise_speed);
    if (!(ratio < S(1))) continue;
    predict_last_bounce(run.bodies, pair, t_s, rise_speed, flight / (S(1) - ratio), ratio);
    if (closing_acceleration * flight * flight / S(8) > root * root * size) continue;
    pair.last_bounce = true;
    pair.remaining_bounces_s = real::max(S(0), pair.bounces_end_s - t_s);
    found = true;
  }
  return found;
}

#define ATWOOD_BOUNCES(S) template bool find_last_bounces<S>(EventRun<S>&, const ImpactProblem<S>&, S);
ATWOOD_BOUNCES(float)
ATWOOD_BOUNCES(double)
ATWOOD_BOUNCES(long double)
#undef ATWOOD_BOUNCES

}  // namespace atwood::event
