// The impacts of one instant.
//
// "sequential": the pair of bodies that approaches fastest collides (ties: the first in the scene's order), then the
// next, until no pair approaches: right for touching cradles. Several points of one pair that move alike (an edge on a
// floor) are as one point; others (a sliding box that lands flat) are solved together. "together": all points of all
// pairs in one complementarity problem (Newton's or Poisson's law at each; for several points at once Stronge's is
// taken as Poisson's):
//   v_n + e v_n- >= 0,  p_n >= 0,  (v_n + e v_n-) p_n = 0,  |p_t| <= mu p_n, slip opposed
//       (Moreau; Glocker and Pfeiffer)
// solved point after point, friction on a round cone, until nothing changes.
#include <algorithm>
#include <cmath>

#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

// Of one instant: beyond the first, what impacts that lose speed have left over is taken at once; those that lose none
// come to an end of their own, or the run does.
constexpr int kMostImpactsAtOnce = 2000, kMostElasticImpactsAtOnce = 1000000;

template <class S> struct Instant {
  EventRun<S>& run;
  S still;            // approach below it is round-off
  int unsettled = 0;  // solutions for several points that did not settle

  const Feature<S>& feature(const Hit<S>& hit) const { return run.features[hit.feature]; }
  Vec3<S> u(const Hit<S>& hit) const {
    const Feature<S>& f = feature(hit);
    const Pose<S>&k = run.poses[f.knob_body], &s = run.poses[f.surface_body];
    return (k.v + cross(k.w, hit.sight.x - k.p)) - (s.v + cross(s.w, hit.sight.x - s.p));
  }
  S vn(const Hit<S>& hit) const { return dot(u(hit), hit.sight.normal); }
};

// Bodies may have gone far from where they began, and round-off of a gap grows with their coordinates.
template <class S> void note_places(EventRun<S>& run) {
  for (const int p : run.near)
    for (const int body : {run.pairs[p].a, run.pairs[p].b}) {
      const int offset = run.model.offset(body);
      if (offset < 0) continue;
      run.length_scale = real::max(run.length_scale, norm(load3(run.y.data() + offset)) + run.reach[body]);
    }
}

template <class S> void find_hits(EventRun<S>& run) {
  run.hits.clear();
  for (const int p : run.near) {
    const ShapePair<S>& pair = run.pairs[p];
    if (!run.moves[pair.a] && !run.moves[pair.b]) continue;
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      const Feature<S>& feature = run.features[f];
      Sight<S> sight = sight_of(run, feature, run.y.data());
      if (!(sight.gap <= run.gap_round_off())) continue;
      Hit<S> hit;
      hit.feature = f;
      hit.pair = p;
      hit.sight = sight;
      run.hits.push_back(hit);
    }
  }
  for (const Hit<S>& hit : run.hits) pose_bodies(run, run.features[hit.feature], run.y.data());
}

template <class S> ImpactLaw<S> law_of(const EventRun<S>& run, int pair) {
  const ShapePair<S>& p = run.pairs[pair];
  return {p.ends ? S(0) : p.restitution, p.friction, p.rolling_friction_m, run.options.restitution};
}

template <class S>
void take_back(EventRun<S>& run, const Feature<S>& f, const ImpactBody<S>& surface, const ImpactBody<S>& knob) {
  if (run.moves[f.surface_body]) {
    run.poses[f.surface_body].v = surface.v_W;
    run.poses[f.surface_body].w = surface.w_W;
  }
  if (run.moves[f.knob_body]) {
    run.poses[f.knob_body].v = knob.v_W;
    run.poses[f.knob_body].w = knob.w_W;
  }
}

template <class S> void collide_one(Instant<S>& now, Hit<S>& hit) {
  EventRun<S>& run = now.run;
  const Feature<S>& f = now.feature(hit);
  ImpactBody<S> surface = impact_body(run, f.surface_body, hit.sight.x),
                knob = impact_body(run, f.knob_body, hit.sight.x);
  const Impulse<S> impulse = collide(law_of(run, hit.pair), hit.sight.normal, surface, knob);
  take_back(run, f, surface, knob);
  run.pending.push_back({hit.pair, f.knob_body == run.pairs[hit.pair].a, hit.sight, impulse});
}

// ---- several points of one pair that move alike -------------------------------------------------------------------
// Is x within the hull of the points, all of them on a plane of normal n?
template <class S> bool supported(const Hit<S>* hits, int count, const Vec3<S>& n, const Vec3<S>& x, S tiny_m) {
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < i; ++j) {
      const Vec3<S>& from = hits[j].sight.x;
      const Vec3<S> side = cross(n, hits[i].sight.x - from);
      const S tiny = tiny_m * norm(side);
      S least = S(0), most = S(0);
      for (int k = 0; k < count; ++k) {
        least = real::min(least, dot(side, hits[k].sight.x - from));
        most = real::max(most, dot(side, hits[k].sight.x - from));
      }
      const S at = dot(side, x - from);
      if ((most <= tiny && at > tiny) || (least >= -tiny && at < -tiny)) return false;
    }
  return true;
}

// An edge that lands on a face, or a face without friction: the points' velocities are equal, and stay so where the
// impulse acts below the centre of mass. They are then as one point there, and every law holds as for one.
template <class S> bool collide_as_one(Instant<S>& now, int first, int count) {
  EventRun<S>& run = now.run;
  const Hit<S>* hits = &run.hits[first];
  const Feature<S>& f = now.feature(hits[0]);
  const Vec3<S>& n = hits[0].sight.normal;
  const S tiny_m = S(4) * run.gap_round_off();
  const Vec3<S> u = now.u(hits[0]), along = hits[1].sight.x - hits[0].sight.x;
  for (int i = 1; i < count; ++i)
    if (norm(hits[i].sight.normal - n) > S(64) * real::epsilon<S>() || norm(now.u(hits[i]) - u) > now.still ||
        now.feature(hits[i]).knob_body != f.knob_body)
      return false;
  Hit<S> one = hits[0];
  const Vec3<S> from = run.poses[run.moves[f.knob_body] ? f.knob_body : f.surface_body].p - hits[0].sight.x;
  one.sight.x += count == 2 ? (dot(from, along) / dot(along, along)) * along : from - dot(from, n) * n;
  if (!supported(hits, count, n, one.sight.x, tiny_m)) return false;
  if (count == 2 && !(dot(one.sight.x - hits[0].sight.x, one.sight.x - hits[1].sight.x) < S(0))) return false;
  ImpactBody<S> surface = impact_body(run, f.surface_body, one.sight.x);
  ImpactBody<S> knob = impact_body(run, f.knob_body, one.sight.x);
  const Impulse<S> impulse = collide(law_of(run, one.pair), n, surface, knob);
  const Vec3<S> turns = knob.w_W - surface.w_W;
  for (int i = 0; i < count; ++i)
    if (norm(cross(turns, hits[i].sight.x - one.sight.x)) > S(16) * now.still) return false;
  take_back(run, f, surface, knob);
  run.pending.push_back({one.pair, f.knob_body == run.pairs[one.pair].a, one.sight, impulse});
  return true;
}

// ---- several points at once ---------------------------------------------------------------------------------------
template <class S> void push_at(Instant<S>& now, Hit<S>& hit, const Vec3<S>& impulse) {
  const Feature<S>& f = now.feature(hit);
  EventRun<S>& run = now.run;
  const auto apply = [&](int body, const ImpactBody<S>& side, const Vec3<S>& j) {
    if (!run.moves[body]) return;
    const Vec3<S> turn = cross(side.r_W, j);
    run.poses[body].v += side.inverse_mass_per_kg * j;
    run.poses[body].w += Vec3<S>{dot(side.I_inverse_W_row[0], turn), dot(side.I_inverse_W_row[1], turn),
                                 dot(side.I_inverse_W_row[2], turn)};
  };
  apply(f.surface_body, hit.surface, -impulse);
  apply(f.knob_body, hit.knob, impulse);
}

// Until v_n >= hit.target wherever p_n = hit.least, p_n >= hit.least. False: the impulses do not settle.
template <class S> bool settle(Instant<S>& now, std::vector<Hit<S>>& hits, int first, int count) {
  constexpr int kMostSweeps = 20000;
  S change = S(0), size = S(0);
  const auto report = [&](int sweeps, SolveEnd ended) {
    const S residual = change == S(0) ? change : change / size;
    now.run.model.system().solvers.add(IterativeSolver::simultaneous_impacts,
                                       {sweeps, static_cast<double>(residual), ended});
  };
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    change = size = S(0);
    for (int i = first; i < first + count; ++i) {
      Hit<S>& hit = hits[i];
      const Vec3<S>& n = hit.sight.normal;
      const S friction = now.run.pairs[hit.pair].friction;
      const S p = real::max(hit.least, hit.normal_N_s - (now.vn(hit) - hit.target) / hit.mobility_n);
      push_at(now, hit, (p - hit.normal_N_s) * n);
      change = real::max(change, real::abs(p - hit.normal_N_s));
      hit.normal_N_s = p;
      size = real::max(size, p);
      if (!(friction > S(0))) continue;
      const Vec3<S> u = now.u(hit), slip = u - dot(u, n) * n;
      Vec3<S> t = hit.tangential_N_s - (S(1) / hit.mobility_t) * slip;
      const S length = norm(t), most = friction * p;
      if (length > most) t = (most / length) * t;
      push_at(now, hit, t - hit.tangential_N_s);
      change = real::max(change, norm(t - hit.tangential_N_s));
      hit.tangential_N_s = t;
    }
    if (change > S(4) * real::epsilon<S>() * size) continue;
    report(sweep + 1, SolveEnd::converged);
    return true;
  }
  report(kMostSweeps, SolveEnd::capped);
  return change <= real::sqrt(real::epsilon<S>()) * size;
}

template <class S> void report_group(Instant<S>& now, int first, int count) {
  EventRun<S>& run = now.run;
  for (int i = first; i < first + count;) {  // one event a pair
    const int pair = run.hits[i].pair;
    int end = i;
    Impulse<S> total;
    Sight<S> at = run.hits[i].sight;
    Vec3<S> x{}, tangential{};
    S before = S(0), after = S(0);
    for (; end < first + count && run.hits[end].pair == pair; ++end) {
      const Hit<S>& hit = run.hits[end];
      const S p = hit.normal_N_s;
      total.normal_N_s += p;
      x += p * hit.sight.x;
      tangential += hit.tangential_N_s;
      before += p * hit.before;
      after += p * now.vn(hit);
    }
    if (total.normal_N_s > S(0)) {
      at.x = (S(1) / total.normal_N_s) * x;  // where the impulses' resultant acts; v_n is linear in the point
      total.vn_before_m_per_s = before / total.normal_N_s;
      total.vn_after_m_per_s = after / total.normal_N_s;
      total.tangential_N_s = norm(tangential);
      run.pending.push_back({pair, now.feature(run.hits[i]).knob_body == run.pairs[pair].a, at, total});
    }
    i = end;
  }
}

// Impulses that do not settle, as friction far beyond 1 has them, stand where they take energy, and no more than a few
// times at one instant: what is left of the approach is the next impact's.
template <class S> bool accept_unsettled(Instant<S>& now, const std::vector<Vec3<S>>& u_before, int first, int count) {
  constexpr int most_unsettled = 4;
  S gain = S(0), size = S(0);  // twice the work of the impulses
  for (int i = 0; i < count; ++i) {
    const Hit<S>& hit = now.run.hits[first + i];
    const Vec3<S> impulse = hit.normal_N_s * hit.sight.normal + hit.tangential_N_s;
    const S part = dot(impulse, u_before[i] + now.u(hit));
    gain += part;
    size += real::abs(part);
  }
  if (++now.unsettled <= most_unsettled && gain <= real::sqrt(real::epsilon<S>()) * size) return true;
  now.run.outcome = {Status::unsupported,
                     "atwood's +event found no impulses of several contacts of one instant that obey Coulomb's law",
                     0,
                     0,
                     {}};
  return false;
}

template <class S> bool collide_together(Instant<S>& now, int first, int count) {
  EventRun<S>& run = now.run;
  const bool newton = run.options.restitution == Restitution::newton;
  std::vector<Vec3<S>> u_before;
  for (int i = first; i < first + count; ++i) {
    Hit<S>& hit = run.hits[i];
    u_before.push_back(now.u(hit));
    const Feature<S>& f = now.feature(hit);
    const ImpactLaw<S> law = law_of(run, hit.pair);
    hit.surface = impact_body(run, f.surface_body, hit.sight.x);
    hit.knob = impact_body(run, f.knob_body, hit.sight.x);
    const Vec3<S>& n = hit.sight.normal;
    const Vec3<S> axis = real::abs(n.x) < S(0.6) ? Vec3<S>{S(1), S(0), S(0)} : Vec3<S>{S(0), S(1), S(0)};
    Vec3<S> t = axis - dot(axis, n) * n;
    t = (S(1) / norm(t)) * t;
    const Vec3<S> t2 = cross(n, t);
    hit.mobility_n = mobility(hit.surface, hit.knob, n);
    hit.mobility_t = real::max(mobility(hit.surface, hit.knob, t), mobility(hit.surface, hit.knob, t2)) +
                     real::abs(mobility(hit.surface, hit.knob, t, t2));
    hit.before = now.vn(hit);
    hit.normal_N_s = hit.least = S(0);
    hit.tangential_N_s = {};
    hit.target = newton && hit.before < S(0) ? -law.restitution * hit.before : S(0);
  }
  bool settled = settle(now, run.hits, first, count);
  if (!newton) {
    bool restores = false;
    for (int i = first; i < first + count; ++i) {
      Hit<S>& hit = run.hits[i];
      hit.least = (S(1) + law_of(run, hit.pair).restitution) * hit.normal_N_s;
      restores = restores || hit.least > hit.normal_N_s;
    }
    if (restores) settled = settle(now, run.hits, first, count) && settled;
  }
  if (!settled && !accept_unsettled(now, u_before, first, count)) return false;
  report_group(now, first, count);
  return true;
}

// ---- the order of impacts -----------------------------------------------------------------------------------------
template <class S> int end_of_pair(const EventRun<S>& run, int first) {
  int end = first;
  while (end < static_cast<int>(run.hits.size()) && run.hits[end].pair == run.hits[first].pair) ++end;
  return end;
}

template <class S> bool all_impacts(Instant<S>& now) {
  EventRun<S>& run = now.run;
  run.pending.clear();
  const int count = static_cast<int>(run.hits.size());
  if (run.options.together) {
    if (count == 1) collide_one(now, run.hits[0]);
    else if (count > 1 && !(end_of_pair(run, 0) == count && collide_as_one(now, 0, count)))
      return collide_together(now, 0, count);
    return true;
  }
  for (int lossy = 0, elastic = 0; lossy < kMostImpactsAtOnce;) {
    int fastest = -1;
    S least = S(0);
    for (int i = 0; i < count; ++i) {  // a tie, within round-off, goes to the first in the scene's order
      const S vn = now.vn(run.hits[i]);
      if (vn < least - now.still) {
        least = vn;
        fastest = i;
      }
    }
    if (fastest < 0) return true;
    if (law_of(run, run.hits[fastest].pair).restitution < S(1)) ++lossy;
    else if (++elastic > kMostElasticImpactsAtOnce) {
      run.outcome = {Status::diverged, "atwood's +event met 1000000 elastic impacts at one instant", 0, 0, {}};
      return false;
    }
    int first = fastest;
    while (first > 0 && run.hits[first - 1].pair == run.hits[fastest].pair) --first;
    const int end = end_of_pair(run, first);
    if (end - first == 1) collide_one(now, run.hits[first]);
    else if (!collide_as_one(now, first, end - first) && !collide_together(now, first, end - first)) return false;
  }
  return collide_together(now, 0, count);  // ever smaller impacts back and forth: what is left of them, at once
}

// ---- the end of a series of bounces -------------------------------------------------------------------------------
// Each touch is located to about eps r / v, so late bounces cost more than they tell: a series is summed once a bounce
// rises by
// less than eps^(2/3) r.   flight T_k = 2 v / a,  rise a T^2 / 8,  rest of the series T_k / (1 - e)
// The impact that ends it is taken without restitution: friction's impulse over the rest of the series, and the way
// that it takes from a sliding body, are then those of a body that slides under its weight from here on, exactly. Each
// impact of a series tells when the series will end, early ones to less round-off: of those that agree with all later
// ones within that of the last, the first is believed.
template <class S> void forecast_end(EventRun<S>& run, ShapePair<S>& pair, S t_s, S rises, S series_s, S ratio) {
  const S places = norm(run.poses[pair.a].p) + norm(run.poses[pair.b].p) + pair.reach;
  const S round_off = S(4) * real::epsilon<S>() * (places / (rises * (S(1) - ratio)) + t_s);
  if (!(real::abs(t_s + series_s - pair.ends_s) <= round_off)) pair.ends_s = t_s + series_s;
}

// What an impact leaves of the pair's approach from bounce to bounce: its restitution, unless others took part, like a
// floor on which one of the two lies.
template <class S> S ratio_of_bounces(const EventRun<S>& run, int pair, S rises) {
  const auto first =
      std::find_if(run.pending.begin(), run.pending.end(), [&](const auto& p) { return p.pair == pair; });
  if (run.pending.size() == 1 || first == run.pending.end()) return run.pairs[pair].restitution;
  return rises / -first->impulse.vn_before_m_per_s;
}

// Contacts that this instant's impacts end do not carry any more.
template <class S> void let_go_of_risen(Instant<S>& now) {
  EventRun<S>& run = now.run;
  for (Contact<S>& contact : run.contacts)
    contact.carries = contact.carries && std::none_of(run.hits.begin(), run.hits.end(), [&](const Hit<S>& hit) {
                        return hit.feature == contact.feature && now.vn(hit) > now.still;
                      });
  run.carrying = static_cast<int>(
      std::count_if(run.contacts.begin(), run.contacts.end(), [](const auto& c) { return c.carries; }));
}

template <class S> bool find_ends(Instant<S>& now, S t_s) {
  EventRun<S>& run = now.run;
  bool found = false, known = false;
  for (int first = 0; first < static_cast<int>(run.hits.size()); first = end_of_pair(run, first)) {
    ShapePair<S>& pair = run.pairs[run.hits[first].pair];
    if (pair.ends || !(pair.restitution > S(0)) || pair.restitution >= S(1)) continue;
    const int end = end_of_pair(run, first);
    S rises = -S(1);
    for (int i = first; i < end; ++i) rises = real::max(rises, now.vn(run.hits[i]));
    const bool hit = std::any_of(run.pending.begin(), run.pending.end(),
                                 [&](const auto& p) { return p.pair == run.hits[first].pair; });
    if (!hit || !(rises > S(0))) continue;
    if (!known) {  // what the bodies would do without the contacts of this instant
      known = true;
      let_go_of_risen(now);
      run.free_rate_of(run.free_context, t_s, run.y.data(), run.dydt.data());
      if (run.carrying > 0) contact_rates(run, t_s, run.y.data(), run.dydt.data());
    }
    S pressing = S(0);
    for (int i = first; i < end; ++i) {
      Contact<S> contact;
      contact.feature = run.hits[i].feature;
      S beside{};
      const Feature<S>& f = run.features[contact.feature];
      contact.facet = facet_under(run, f, beside);
      contact.sight =
          watch(f.knob, run.poses[f.knob_body], run.surfaces[f.surface], contact.facet, run.poses[f.surface_body]);
      contact.u = now.u(run.hits[i]);
      pressing = real::max(pressing, -normal_acceleration(run, contact, run.dydt.data()));
    }
    if (!(pressing > S(0))) continue;
    const S size_a = run.reach[pair.a] > S(0) ? run.reach[pair.a] : run.reach[pair.b];
    const S size = run.reach[pair.b] > S(0) ? real::min(size_a, run.reach[pair.b]) : size_a;
    const S flight = S(2) * rises / pressing, root = std::cbrt(real::epsilon<S>());
    const S ratio = ratio_of_bounces(run, run.hits[first].pair, rises);
    if (!(ratio < S(1))) continue;
    forecast_end(run, pair, t_s, rises, flight / (S(1) - ratio), ratio);
    if (pressing * flight * flight / S(8) > root * root * size) continue;
    pair.ends = true;
    pair.tail_s = real::max(S(0), pair.ends_s - t_s);
    found = true;
  }
  return found;
}

template <class S> void load_poses(EventRun<S>& run) {
  for (const Hit<S>& hit : run.hits) pose_bodies(run, run.features[hit.feature], run.y.data());
}

template <class S> void store_velocities(EventRun<S>& run) {
  for (const Hit<S>& hit : run.hits)
    for (const int body : {run.features[hit.feature].knob_body, run.features[hit.feature].surface_body})
      store_velocity(run, body, run.poses[body].v, run.poses[body].w, run.y.data());
}

template <class S> void drop_kicked(EventRun<S>& run, S still) {
  std::erase_if(run.contacts, [&](const Contact<S>& contact) {
    const Sight<S> sight = sight_of(run, run.features[contact.feature], run.y.data());
    if (!(real::abs(sight.rate) > still)) return false;
    run.features[contact.feature].lasting = false;
    return true;
  });
}

}  // namespace

template <class S> bool resolve_impacts(EventRun<S>& run, S t_s) {
  note_places(run);
  list_crossing_edges(run, run.y.data());
  find_hits(run);
  if (!refuse_parallel_edges(run, t_s)) return false;
  Instant<S> now{run, run.approach_round_off()};
  for (const Hit<S>& hit : run.hits) run.pairs[hit.pair].ends = false;
  run.y_kept = run.y;
  if (!all_impacts(now)) return false;
  store_velocities(run);
  if (find_ends(now, t_s)) {
    run.y = run.y_kept;
    load_poses(run);
    if (!all_impacts(now)) return false;
    store_velocities(run);
  }
  for (const Pending<S>& made : run.pending)
    if (!made.impulse.finished) {
      run.outcome = {Status::diverged,
                     "atwood's +event: the path of an impact's slip at t = " + format_double(static_cast<double>(t_s)) +
                         " s was not followed to its end",
                     0,
                     0,
                     {}};
      return false;
    }
  for (const Pending<S>& made : run.pending)
    report_event(run, EventKind::impact, run.pairs[made.pair], made.sight, made.knob_is_a, made.impulse, t_s);
  drop_kicked(run, run.slip_round_off());
  if (!review_contacts(run, t_s, true)) return false;
  for (std::size_t i = 0; i < run.pending.size(); ++i) {
    const Pending<S>& made = run.pending[i];
    ShapePair<S>& pair = run.pairs[made.pair];
    const bool again = std::any_of(run.pending.begin(), run.pending.begin() + static_cast<std::ptrdiff_t>(i),
                                   [&](const Pending<S>& earlier) { return earlier.pair == made.pair; });
    const bool lasts = std::any_of(run.contacts.begin(), run.contacts.end(), [&](const Contact<S>& contact) {
      return run.features[contact.feature].pair == made.pair;
    });
    const bool was =
        std::any_of(run.contacts_before.begin(), run.contacts_before.end(),
                    [&](const Contact<S>& contact) { return run.features[contact.feature].pair == made.pair; });
    if (!again && lasts && !was)
      report_event(run, EventKind::rest, pair, made.sight, made.knob_is_a, Impulse<S>{},
                   t_s + (pair.ends ? pair.tail_s : S(0)));
  }
  for (const Pending<S>& made : run.pending) run.pairs[made.pair].ends = false;
  project_contacts(run, run.y.data());
  return run.inconsistent < 0 || strike(run, t_s);
}

template bool resolve_impacts<float>(EventRun<float>&, float);
template bool resolve_impacts<double>(EventRun<double>&, double);
template bool resolve_impacts<long double>(EventRun<long double>&, long double);

}  // namespace atwood::event
