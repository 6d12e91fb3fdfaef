// Lasting contacts: which candidates join them, their modes and forces, and which separate.
#include "contact/event/active_set.hpp"

#include <algorithm>

#include "contact/event/contact_forces.hpp"
#include "contact/event/gauss_seidel.hpp"
#include "contact/event/modes.hpp"
#include "contact/event/painleve.hpp"
#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

enum class PairState : unsigned char { separated, frictionless, slipping, sticking, rolling };

// Scale of accelerations [m/s^2]: the largest |v'| without contact forces + w^2 r of a body in contact.
template <class S> S acceleration_scale(const Bodies<S>& bodies, const ActiveSet<S>& active, const S* dydt) {
  S size = S(0);
  for (const int body : active.bodies) {
    if (!bodies.moves[body]) continue;
    const Vec3<S> a = load3(dydt + bodies.model.offset(body) + kAtVelocity);
    const S w = norm(bodies.poses[body].w);
    size = real::max(size, norm(a) + w * w * bodies.bounding_radius[body]);
  }
  return size;
}

// w^2 r [m/s^2] of the largest spin that counts as round-off: it bounds the scale where no force acts, as after an
// impact with e = 0.
template <class S> S round_off_acceleration(const Bodies<S>& bodies, const ActiveSet<S>& active) {
  S most = S(0);
  for (const int body : active.bodies)
    if (bodies.moves[body] && bodies.bounding_radius[body] > S(0))
      most = real::max(most, bodies.slip_round_off() * bodies.slip_round_off() / bodies.bounding_radius[body]);
  return most;
}

// The state of a pair by its active contacts: slipping where one of them slips, else rolling before sticking.
template <class S>
PairState pair_state(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active, int pair) {
  PairState state = PairState::separated;
  for (const Contact<S>& contact : active.contacts) {
    if (proximity.candidates[contact.candidate].pair != pair || !contact.active) continue;
    if (contact.mode == FrictionMode::slip && !contact.at_cone_limit) return PairState::slipping;
    if (contact.mode == FrictionMode::frictionless) state = PairState::frictionless;
    else if (state != PairState::rolling)
      state = norm(perpendicular_part(contact.w, contact.kinematics.normal)) >
                      bodies.slip_round_off() / proximity.pairs[pair].bounding_radii
                  ? PairState::rolling
                  : PairState::sticking;
  }
  return state;
}

// Poses of the bodies in contact, and the contacts' gaps and relative velocities, at states.y.
template <class S>
void update_all_kinematics(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                           const StateBuffers<S>& states) {
  bodies.poses_version = 0;
  for (const int body : active.bodies) bodies.poses[body] = pose_of(bodies, body, states.y.data());
  for (Contact<S>& contact : active.contacts) {
    const Candidate<S>& candidate = proximity.candidates[contact.candidate];
    const Pose<S>&of = bodies.poses[candidate.feature_body], &on = bodies.poses[candidate.surface_body];
    contact.kinematics =
        gap_kinematics_with_rates(candidate.feature, of, proximity.surfaces[candidate.surface], contact.facet, on);
    contact.u = (of.v + cross(of.w, contact.kinematics.x - of.p)) - (on.v + cross(on.w, contact.kinematics.x - on.p));
    contact.w = of.w - on.w;
    contact.kinematics_version = 0;
  }
}

// Candidates that are closed and neither approach nor separate become contacts.
template <class S>
void add_closed_candidates(Bodies<S>& bodies, Proximity<S>& proximity, ActiveSet<S>& active,
                           const StateBuffers<S>& states) {
  for (const int p : proximity.near) {
    const ShapePair<S>& pair = proximity.pairs[p];
    if (!bodies.moves[pair.a] && !bodies.moves[pair.b]) continue;
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      Candidate<S>& candidate = proximity.candidates[f];
      if (candidate.in_contact) continue;
      const GapKinematics<S> kinematics = gap_at(bodies, proximity, candidate, states.y.data());
      if (!(kinematics.gap <= bodies.gap_round_off()) || real::abs(kinematics.rate) > bodies.slip_round_off()) continue;
      update_poses(bodies, candidate, states.y.data());
      Contact<S> contact;
      contact.candidate = f;
      S outside_m{};
      contact.facet = facet_below(bodies, proximity, candidate, outside_m);
      if (pair.overlaps_at_start && kinematics.gap < -bodies.gap_round_off()) contact.target_gap = kinematics.gap;
      candidate.in_contact = true;
      active.contacts.push_back(contact);
    }
  }
}

// Sets active.bodies: those with a state, each once.
template <class S> void list_contact_bodies(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active) {
  active.bodies.clear();
  bodies.poses_version = 0;
  for (const Contact<S>& contact : active.contacts)
    for (const int body :
         {proximity.candidates[contact.candidate].feature_body, proximity.candidates[contact.candidate].surface_body})
      if (bodies.model.offset(body) >= 0 &&
          std::find(active.bodies.begin(), active.bodies.end(), body) == active.bodies.end())
        active.bodies.push_back(body);
}

template <class S> void count_active(ActiveSet<S>& active) {
  active.count = static_cast<int>(
      std::count_if(active.contacts.begin(), active.contacts.end(), [](const Contact<S>& c) { return c.active; }));
}

// Removes contacts that are not active and whose gap opens faster than `tiny_acceleration`.
template <class S>
void drop_separating(const Bodies<S>& bodies, Proximity<S>& proximity, ActiveSet<S>& active,
                     const StateBuffers<S>& states, S tiny_acceleration) {
  std::erase_if(active.contacts, [&](const Contact<S>& contact) {
    const bool leaves =
        !contact.active && normal_acceleration(bodies, proximity, contact, states.dydt.data()) > tiny_acceleration;
    if (leaves) proximity.candidates[contact.candidate].in_contact = false;
    return leaves;
  });
}

// Reports the event by which the pair's state changed, where the observer has one for it.
template <class S>
void report_mode_change(const Proximity<S>& proximity, const Report& report, const Contact<S>& contact,
                        PairState before, PairState now, S t_s) {
  if (before == now || before == PairState::separated) return;
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  const ShapePair<S>& pair = proximity.pairs[candidate.pair];
  EventKind kind = EventKind::separate;
  if (now == PairState::slipping) kind = EventKind::slip;
  else if (now == PairState::sticking && before == PairState::slipping) kind = EventKind::stick;
  else if (now == PairState::rolling && before == PairState::slipping) kind = EventKind::roll;
  else if (now != PairState::separated) return;
  report_event(report, kind, pair, contact.kinematics, candidate.feature_body == pair.a, Impulse<S>{}, t_s);
}

// Below these, accelerations and forces are round-off of their own computation.
template <class S> Tolerances<S> tolerances_of(const Bodies<S>& bodies, const ActiveSet<S>& active, const S* dydt) {
  const S size = acceleration_scale(bodies, active, dydt);
  S heaviest = S(0);
  for (const int body : active.bodies) heaviest = real::max(heaviest, bodies.model.mass(body).mass_kg);
  const S spin_round_off = round_off_acceleration(bodies, active);
  return {size, heaviest, real::max(S(1e6) * real::epsilon<S>() * size, spin_round_off),
          real::max(S(1e5) * real::epsilon<S>() * size, spin_round_off) * heaviest};
}

// Modes and forces of the contacts at states.y; drops those that separate. False: no forces obey the laws, or they are
// not unique.
template <class S> bool find_modes(EventRun<S>& run, S t_s) {
  ActiveSet<S>& active = run.active;
  list_contact_bodies(run.bodies, run.proximity, active);
  update_all_kinematics(run.bodies, run.proximity, active, run.states);
  modes_from_velocities(run.bodies, run.proximity, active);
  release_cone_limits(run.proximity, active);
  count_active(active);
  run.constraints.solvable = true;
  run.integration.free.rate(t_s, run.states.y.data(), run.states.dydt.data());
  const Tolerances<S> tolerances = tolerances_of(run.bodies, active, run.states.dydt.data());
  for (Contact<S>& contact : active.contacts) {
    contact.warm_start_N = contact.largest_N = S(0);
    contact.warm_start_friction_N = contact.warm_start_couple_N_m = {};
  }
  if (active.count > 0)
    add_contact_forces(run.bodies, run.proximity, active, run.constraints, run.states.y.data(), run.states.y.version,
                       run.states.dydt.data());
  if (!laws_hold(run.proximity, active, run.constraints, tolerances.force_N) && !search_modes(run, t_s, tolerances)) {
    run.integration.free.rate(t_s, run.states.y.data(), run.states.dydt.data());
    solve_forces_gauss_seidel(run.bodies, run.proximity, active, run.constraints, run.states.dydt.data(), S(0));
    modes_from_forces(run.proximity, active, tolerances.force_N, tolerances.acceleration);
    release_cone_limits(run.proximity, active);
    count_active(active);
    run.constraints.solvable = true;
    if (active.count > 0)
      add_contact_forces(run.bodies, run.proximity, active, run.constraints, run.states.y.data(), run.states.y.version,
                         run.states.dydt.data());
  }
  for (Contact<S>& contact : active.contacts) contact.reached_cone = false;
  if (!run.constraints.solvable)
    return end_run(
        run.report, Status::diverged,
        "atwood's +event: the contact equations at t = " + format_double(static_cast<double>(t_s)) + " s are singular");
  // Forces of several contacts are accurate to sqrt(eps) only.
  const S coarse = active.contacts.size() > 1 ? real::sqrt(real::epsilon<S>()) * tolerances.scale : S(0);
  active.separation_acceleration = S(4) * real::max(tolerances.acceleration, coarse);
  if (!check_forces(run, t_s, real::max(tolerances.acceleration, coarse),
                    real::max(tolerances.force_N, coarse * tolerances.heaviest_kg)))
    return false;
  drop_separating(run.bodies, run.proximity, active, run.states, tolerances.acceleration);
  count_active(active);
  list_contact_bodies(run.bodies, run.proximity, active);
  return true;
}

}  // namespace

template <class S>
void report_event(const Report& report, EventKind kind, const ShapePair<S>& pair, const GapKinematics<S>& kinematics,
                  bool feature_is_a, const Impulse<S>& impulse, S t_s) {
  if (!report.observer || !report.observer->event) return;
  const Vec3<S> normal = feature_is_a ? -kinematics.normal : kinematics.normal,
                x = kinematics.x - (kinematics.gap / S(2)) * kinematics.normal;
  Event event;
  event.t_s = Wide(t_s);
  event.kind = kind;
  event.body_a = pair.a;
  event.body_b = pair.b;
  event.x_m = {Wide(x.x), Wide(x.y), Wide(x.z)};
  event.normal = {Wide(normal.x), Wide(normal.y), Wide(normal.z)};
  event.impulse_n_N_s = Wide(impulse.normal_N_s);
  event.impulse_t_N_s = Wide(impulse.tangential_N_s);
  event.vn_before_m_per_s = Wide(impulse.vn_before_m_per_s);
  event.vn_after_m_per_s = Wide(impulse.vn_after_m_per_s);
  report.observer->event(event);
}

template <class S> bool update_active_set(EventRun<S>& run, S t_s) {
  ActiveSet<S>& active = run.active;
  active.inconsistent = -1;
  const std::vector<Contact<S>>& previous = active.previous;
  active.previous = active.contacts;
  const auto pair_of = [&](const Contact<S>& contact) { return run.proximity.candidates[contact.candidate].pair; };
  std::vector<unsigned char>& states = active.previous_states;  // of each previous contact's pair
  states.clear();
  for (const Contact<S>& contact : previous)
    states.push_back(static_cast<unsigned char>(pair_state(run.bodies, run.proximity, active, pair_of(contact))));
  std::erase_if(active.contacts, [](const Contact<S>& contact) { return contact.left_facet; });
  add_closed_candidates(run.bodies, run.proximity, active, run.states);
  active.count = 0;
  if (!active.contacts.empty() && !find_modes(run, t_s)) return false;
  ++run.bodies.model.system().epoch;
  active.active_set_epoch = run.bodies.model.system().epoch;
  for (std::size_t i = 0; i < previous.size(); ++i) {
    const int pair = pair_of(previous[i]);
    if (i > 0 && pair_of(previous[i - 1]) == pair) continue;  // one event per pair, whose contacts change together
    report_mode_change(run.proximity, run.report, previous[i], static_cast<PairState>(states[i]),
                       pair_state(run.bodies, run.proximity, active, pair), t_s);
  }
  return true;
}

#define ATWOOD_ACTIVE_SET(S)                                                                                  \
  template void report_event<S>(const Report&, EventKind, const ShapePair<S>&, const GapKinematics<S>&, bool, \
                                const Impulse<S>&, S);                                                        \
  template bool update_active_set<S>(EventRun<S>&, S);
ATWOOD_ACTIVE_SET(float)
ATWOOD_ACTIVE_SET(double)
ATWOOD_ACTIVE_SET(long double)
#undef ATWOOD_ACTIVE_SET

}  // namespace atwood::event
