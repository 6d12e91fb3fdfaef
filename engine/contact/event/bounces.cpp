#include "contact/event/bounces.hpp"

#include <algorithm>
#include <cmath>

#include "contact/event/contact_forces.hpp"

namespace atwood::event {

namespace {

// Each touch is located to about eps r / v, so late bounces cost more than they tell: a series is summed once a bounce
// rises by
// less than eps^(2/3) r.   flight T_k = 2 v / a,  rise a T^2 / 8,  rest of the series T_k / (1 - e)
// The impact that ends it is taken without restitution: friction's impulse over the rest of the series, and the way
// that it takes from a sliding body, are then those of a body that slides under its weight from here on, exactly. Each
// impact of a series tells when the series will end, early ones to less round-off: of those that agree with all later
// ones within that of the last, the first is believed.
template <class S>
void predict_last_bounce(const Bodies<S>& bodies, ShapePair<S>& pair, S t_s, S rises, S series_s, S ratio) {
  const S places = norm(bodies.poses[pair.a].p) + norm(bodies.poses[pair.b].p) + pair.bounding_radii;
  const S round_off = S(4) * real::epsilon<S>() * (places / (rises * (S(1) - ratio)) + t_s);
  if (!(real::abs(t_s + series_s - pair.bounces_end_s) <= round_off)) pair.bounces_end_s = t_s + series_s;
}

// What an impact leaves of the pair's approach from bounce to bounce: its restitution, unless others took part, like a
// floor on which one of the two lies.
template <class S> S ratio_of_bounces(const Proximity<S>& proximity, const Impacts<S>& impacts, int pair, S rises) {
  const auto first =
      std::find_if(impacts.applied.begin(), impacts.applied.end(), [&](const auto& p) { return p.pair == pair; });
  if (impacts.applied.size() == 1 || first == impacts.applied.end()) return proximity.pairs[pair].restitution;
  return rises / -first->impulse.vn_before_m_per_s;
}

// Contacts that this instant's impacts end do not carry any more.
template <class S> void deactivate_separating(EventRun<S>& run, const ImpactProblem<S>& problem) {
  for (Contact<S>& contact : run.active.contacts)
    contact.active =
        contact.active &&
        std::none_of(run.impacts.points.begin(), run.impacts.points.end(), [&](const ImpactPoint<S>& point) {
          return point.candidate == contact.candidate && problem.vn(point) > problem.still;
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
    S rises = -S(1);
    for (int i = first; i < end; ++i) rises = real::max(rises, problem.vn(run.impacts.points[i]));
    const bool point = std::any_of(run.impacts.applied.begin(), run.impacts.applied.end(),
                                   [&](const auto& p) { return p.pair == run.impacts.points[first].pair; });
    if (!point || !(rises > S(0))) continue;
    if (!known) {  // what the bodies would do without the contacts of this instant
      known = true;
      deactivate_separating(run, problem);
      run.integration.free.rate(t_s, run.states.y.data(), run.states.dydt.data());
      if (run.active.count > 0)
        add_contact_forces(run.bodies, run.proximity, run.active, run.constraints, run.states.y.data(),
                           run.states.y.version, run.states.dydt.data());
    }
    S pressing = S(0);
    for (int i = first; i < end; ++i) {
      Contact<S> contact;
      contact.candidate = run.impacts.points[i].candidate;
      S outside_m{};
      const Candidate<S>& f = run.proximity.candidates[contact.candidate];
      contact.facet = facet_below(run.bodies, run.proximity, f, outside_m);
      contact.kinematics =
          gap_kinematics_with_rates(f.feature, run.bodies.poses[f.feature_body], run.proximity.surfaces[f.surface],
                                    contact.facet, run.bodies.poses[f.surface_body]);
      contact.u = problem.u(run.impacts.points[i]);
      pressing = real::max(pressing, -normal_acceleration(run.bodies, run.proximity, contact, run.states.dydt.data()));
    }
    if (!(pressing > S(0))) continue;
    const S size_a = run.bodies.bounding_radius[pair.a] > S(0) ? run.bodies.bounding_radius[pair.a]
                                                               : run.bodies.bounding_radius[pair.b];
    const S size =
        run.bodies.bounding_radius[pair.b] > S(0) ? real::min(size_a, run.bodies.bounding_radius[pair.b]) : size_a;
    const S flight = S(2) * rises / pressing, root = std::cbrt(real::epsilon<S>());
    const S ratio = ratio_of_bounces(run.proximity, run.impacts, run.impacts.points[first].pair, rises);
    if (!(ratio < S(1))) continue;
    predict_last_bounce(run.bodies, pair, t_s, rises, flight / (S(1) - ratio), ratio);
    if (pressing * flight * flight / S(8) > root * root * size) continue;
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
