// Which contacts touch, which carry, which slip and which hold, at one instant.
//
// First all contacts carry, and what has no slip holds: where the forces for that obey the laws, they are it. Else who
// pulls lets go, who would leave his cone slips along what held him, and so on, as long as what follows agrees with
// the laws. Where it does not, forces are settled contact by contact (settle.cpp), and tell who lets go, who slips and
// along what; redundant contacts may stand at the edge of their cones while others hold the body.
#include <algorithm>

#include "contact/event/contact_forces.hpp"
#include "contact/event/gauss_seidel.hpp"
#include "contact/event/painleve.hpp"
#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

enum class PairState : unsigned char { separated, frictionless, slipping, sticking, rolling };

template <class S> Vec3<S> across(const Vec3<S>& v, const Vec3<S>& n) { return v - dot(v, n) * n; }

// Of the bodies' accelerations without contacts, plus what circling gives.
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

// What circles at a speed of round-off: after a dead impact far from any force nothing else is left.
template <class S> S round_off_acceleration(const Bodies<S>& bodies, const ActiveSet<S>& active) {
  S most = S(0);
  for (const int body : active.bodies)
    if (bodies.moves[body] && bodies.bounding_radius[body] > S(0))
      most = real::max(most, bodies.slip_round_off() * bodies.slip_round_off() / bodies.bounding_radius[body]);
  return most;
}

template <class S>
PairState pair_state(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active, int pair) {
  PairState state = PairState::separated;
  for (const Contact<S>& contact : active.contacts) {
    if (proximity.candidates[contact.candidate].pair != pair || !contact.active) continue;
    if (contact.mode == FrictionMode::slip && !contact.at_cone_limit) return PairState::slipping;
    if (contact.mode == FrictionMode::frictionless) state = PairState::frictionless;
    else if (state != PairState::rolling)
      state = norm(across(contact.w, contact.kinematics.normal)) >
                      bodies.slip_round_off() / proximity.pairs[pair].bounding_radii
                  ? PairState::rolling
                  : PairState::sticking;
  }
  return state;
}

template <class S>
void update_all_kinematics(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                           const StateBuffers<S>& states) {
  bodies.poses_at = 0;
  for (const int body : active.bodies) bodies.poses[body] = pose_of(bodies, body, states.y.data());
  for (Contact<S>& contact : active.contacts) {
    const Candidate<S>& candidate = proximity.candidates[contact.candidate];
    const Pose<S>&of = bodies.poses[candidate.feature_body], &on = bodies.poses[candidate.surface_body];
    contact.kinematics =
        gap_kinematics_with_rates(candidate.feature, of, proximity.surfaces[candidate.surface], contact.facet, on);
    contact.u = (of.v + cross(of.w, contact.kinematics.x - of.p)) - (on.v + cross(on.w, contact.kinematics.x - on.p));
    contact.w = of.w - on.w;
    contact.kinematics_at = 0;
  }
}

// Features that touch and neither approach nor leave join the contacts.
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
      if (kinematics.gap < -bodies.gap_round_off()) contact.held_gap = kinematics.gap;
      candidate.in_contact = true;
      active.contacts.push_back(contact);
    }
  }
}

template <class S> void list_contact_bodies(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active) {
  active.bodies.clear();
  bodies.poses_at = 0;
  for (const Contact<S>& contact : active.contacts)
    for (const int body :
         {proximity.candidates[contact.candidate].feature_body, proximity.candidates[contact.candidate].surface_body})
      if (bodies.model.offset(body) >= 0 &&
          std::find(active.bodies.begin(), active.bodies.end(), body) == active.bodies.end())
        active.bodies.push_back(body);
}

template <class S>
void modes_from_velocities(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active) {
  for (Contact<S>& contact : active.contacts) contact.slip_speed = norm(across(contact.u, contact.kinematics.normal));
  for (Contact<S>& contact : active.contacts) {
    const int p = proximity.candidates[contact.candidate].pair;
    const ShapePair<S>& pair = proximity.pairs[p];
    const Vec3<S> slip = across(contact.u, contact.kinematics.normal),
                  roll = across(contact.w, contact.kinematics.normal);
    const S speed = norm(slip), rolling = norm(roll), still = bodies.slip_round_off();
    // Corners of one body stop together: where one has stopped, the others' round-off may be somewhat more.
    const bool stops = !(speed > S(64) * still) &&
                       std::any_of(active.contacts.begin(), active.contacts.end(), [&](const Contact<S>& other) {
                         return proximity.candidates[other.candidate].pair == p && !(other.slip_speed > still);
                       });
    contact.active = true;
    contact.slip_speed = speed;
    contact.roll_speed = rolling;
    if (!(pair.friction > S(0))) contact.mode = FrictionMode::frictionless;
    else if (!stops) {
      contact.mode = FrictionMode::slip;
      contact.slip_direction = (S(1) / speed) * slip;
      contact.at_cone_limit = false;
    } else if (!contact.reached_cone) {
      contact.mode = FrictionMode::stick;
      contact.at_cone_limit = false;
    }
    if (!(pair.rolling_friction_m > S(0))) contact.rolling = RollingMode::free;
    else if (rolling * pair.bounding_radii > still) {
      contact.rolling = RollingMode::roll;
      contact.roll_direction = (S(1) / rolling) * roll;
    } else if (!contact.reached_rolling_bound) {
      contact.rolling = RollingMode::hold;
    }
    contact.reached_rolling_bound = false;
  }
}

template <class S> void clear_cone_marks(ActiveSet<S>& active) {
  for (Contact<S>& contact : active.contacts) contact.reached_cone = false;
}

template <class S> void count_active(ActiveSet<S>& active) {
  active.count = static_cast<int>(
      std::count_if(active.contacts.begin(), active.contacts.end(), [](const Contact<S>& c) { return c.active; }));
}

// Do the forces of the linear solve, all contacts active_count and what has no slip holding, obey the laws as they are?
template <class S>
bool laws_hold(const Proximity<S>& proximity, const ActiveSet<S>& active, const ConstraintSystem<S>& constraints,
               S tiny_N) {
  return constraints.solvable &&
         std::all_of(active.contacts.begin(), active.contacts.end(), [&](const Contact<S>& contact) {
           const ShapePair<S>& pair = proximity.pairs[proximity.candidates[contact.candidate].pair];
           if (!contact.active || contact.at_cone_limit || contact.normal_N < tiny_N) return false;
           if (pair.count == 1 && !(contact.normal_N > tiny_N)) return false;
           if (contact.mode == FrictionMode::stick && norm(contact.friction_N) > pair.friction * contact.normal_N)
             return false;
           return contact.rolling != RollingMode::hold ||
                  norm(contact.couple_N_m) <= pair.rolling_friction_m * contact.normal_N;
         });
}

// ---- from linear solve to linear solve ------------------------------------------------------------------------------
constexpr int kMostGuesses = 12;

// Who pulls lets go, who is past his cone slips; true: somebody did.
template <class S> bool release_violated(const Proximity<S>& proximity, ActiveSet<S>& active, S tiny_N) {
  bool changed = false;
  for (Contact<S>& contact : active.contacts) {
    if (!contact.active || contact.normal_N > tiny_N) continue;
    contact.active = false;
    changed = true;
  }
  if (changed) return true;
  for (Contact<S>& contact : active.contacts) {
    if (!contact.active) continue;
    const ShapePair<S>& pair = proximity.pairs[proximity.candidates[contact.candidate].pair];
    const S held = norm(contact.friction_N), turned = norm(contact.couple_N_m);
    if (contact.mode == FrictionMode::stick && held > pair.friction * contact.normal_N) {
      contact.mode = FrictionMode::slip;
      contact.slip_direction = (S(-1) / held) * contact.friction_N;
      changed = true;
    }
    if (contact.rolling == RollingMode::hold && turned > pair.rolling_friction_m * contact.normal_N) {
      contact.rolling = RollingMode::roll;
      contact.roll_direction = (S(-1) / turned) * contact.couple_N_m;
      changed = true;
    }
  }
  return changed;
}

// What sets in must go where its friction says, or nowhere: then others hold it at the edge of its cone.
template <class S>
bool accelerates_along(const Vec3<S>& sets_in, const Vec3<S>& direction, S tiny, bool& at_cone_limit) {
  const S along = dot(sets_in, direction), aside = norm(sets_in - along * direction);
  at_cone_limit = !(norm(sets_in) > tiny);
  return at_cone_limit || (along > S(0) && aside <= real::sqrt(real::epsilon<S>()) * along + tiny);
}

// Does what has been let go go, and along what its friction says? Who is pressed again active again: `pressed`.
template <class S>
bool released_consistent(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                         const StateBuffers<S>& states, S tiny_acceleration, bool& pressed) {
  pressed = false;
  for (Contact<S>& contact : active.contacts) {
    if (contact.active) continue;
    if (normal_acceleration(bodies, proximity, contact, states.dydt.data()) < -tiny_acceleration)
      contact.active = pressed = true;
  }
  if (pressed) return true;
  for (Contact<S>& contact : active.contacts) {
    if (!contact.active) continue;
    const Vec3<S>& n = contact.kinematics.normal;
    bool at_cone_limit = false;
    if (contact.mode == FrictionMode::slip && !(contact.slip_speed > bodies.slip_round_off())) {
      const Vec3<S> sets_in = across(relative_acceleration(bodies, proximity, contact, states.dydt.data()), n);
      if (!accelerates_along(sets_in, contact.slip_direction, tiny_acceleration, at_cone_limit)) return false;
      contact.at_cone_limit = at_cone_limit;
    }
    const S radius = proximity.pairs[proximity.candidates[contact.candidate].pair].bounding_radii;
    if (contact.rolling == RollingMode::roll && !(contact.roll_speed * radius > bodies.slip_round_off())) {
      const Vec3<S> sets_in =
          radius * across(relative_angular_acceleration(bodies, proximity, contact, states.dydt.data()), n);
      if (!accelerates_along(sets_in, contact.roll_direction, tiny_acceleration, at_cone_limit) || at_cone_limit)
        return false;
    }
  }
  return true;
}

// Forces that obey the laws, and modes with them; false: none was found, modes are as they were.
template <class S> bool search_modes(EventRun<S>& run, S t_s, S tiny_N, S tiny_acceleration) {
  if (std::any_of(run.active.contacts.begin(), run.active.contacts.end(),
                  [](const Contact<S>& c) { return c.at_cone_limit; }))
    return false;
  run.active.kept = run.active.contacts;
  for (int guess = 0; guess < kMostGuesses && run.constraints.solvable; ++guess) {
    if (release_violated(run.proximity, run.active, tiny_N)) {
      run.integration.free.rate(t_s, run.states.y.data(), run.states.dydt.data());
      add_contact_forces(run.bodies, run.proximity, run.active, run.constraints, run.states.y.data(),
                         run.states.y.version, run.states.dydt.data());
      continue;
    }
    bool pressed = false;
    if (!released_consistent(run.bodies, run.proximity, run.active, run.states, tiny_acceleration, pressed)) break;
    if (!pressed) return true;
    run.integration.free.rate(t_s, run.states.y.data(), run.states.dydt.data());
    add_contact_forces(run.bodies, run.proximity, run.active, run.constraints, run.states.y.data(),
                       run.states.y.version, run.states.dydt.data());
  }
  run.active.contacts.swap(run.active.kept);
  run.constraints.solvable = true;
  return false;
}

// Modes from settled forces.
template <class S>
void modes_from_forces(const Proximity<S>& proximity, ActiveSet<S>& active, S tiny_N, S tiny_acceleration) {
  for (Contact<S>& contact : active.contacts) {
    const ShapePair<S>& pair = proximity.pairs[proximity.candidates[contact.candidate].pair];
    const Vec3<S>& n = contact.kinematics.normal;
    contact.active = contact.normal_N > tiny_N;
    contact.warm_N = contact.normal_N;
    contact.largest_N = real::max(contact.largest_N, contact.normal_N);
    if (contact.mode != FrictionMode::frictionless && (contact.mode == FrictionMode::stick || contact.at_cone_limit)) {
      const Vec3<S> sets_in = across(contact.u_dot, n);
      const S size = norm(sets_in), held = norm(contact.friction_N);
      contact.mode = FrictionMode::stick;
      contact.at_cone_limit = false;
      if (size > tiny_acceleration) {
        contact.mode = FrictionMode::slip;
        contact.slip_direction = (S(1) / size) * sets_in;
      } else if (held > S(0) && (contact.reached_cone || held > pair.friction * contact.normal_N - tiny_N)) {
        contact.mode = FrictionMode::slip;
        contact.at_cone_limit = true;
        contact.slip_direction = (S(-1) / held) * contact.friction_N;
      }
    }
    if (contact.rolling == RollingMode::hold) {
      const Vec3<S> sets_in = across(contact.alpha, n);
      const S size = norm(sets_in);
      if (size * pair.bounding_radii > tiny_acceleration) {
        contact.rolling = RollingMode::roll;
        contact.roll_direction = (S(1) / size) * sets_in;
      }
    }
  }
}

// A pair whose contacts all stand at the edge of their cones has nothing left that holds it.
template <class S> void release_cone_limits(const Proximity<S>& proximity, ActiveSet<S>& active) {
  for (Contact<S>& contact : active.contacts) {
    if (!contact.at_cone_limit) continue;
    const int pair = proximity.candidates[contact.candidate].pair;
    contact.at_cone_limit = std::any_of(active.contacts.begin(), active.contacts.end(), [&](const Contact<S>& other) {
      return other.active && other.mode == FrictionMode::stick && proximity.candidates[other.candidate].pair == pair;
    });
  }
}

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

template <class S> bool update_active_set(EventRun<S>& run, S t_s, bool report) {
  run.active.inconsistent = -1;
  const std::vector<Contact<S>>& old = run.active.previous;
  run.active.previous = run.active.contacts;
  std::vector<unsigned char>& state = run.active.previous_states;  // of each old contact's pair
  state.clear();
  if (report)
    for (const Contact<S>& contact : old) {
      const int pair = run.proximity.candidates[contact.candidate].pair;
      state.push_back(static_cast<unsigned char>(pair_state(run.bodies, run.proximity, run.active, pair)));
    }
  add_closed_candidates(run.bodies, run.proximity, run.active, run.states);
  run.active.count = 0;
  if (!run.active.contacts.empty()) {
    list_contact_bodies(run.bodies, run.proximity, run.active);
    update_all_kinematics(run.bodies, run.proximity, run.active, run.states);
    modes_from_velocities(run.bodies, run.proximity, run.active);
    release_cone_limits(run.proximity, run.active);
    count_active(run.active);
    run.constraints.solvable = true;
    run.integration.free.rate(t_s, run.states.y.data(), run.states.dydt.data());
    const S size = acceleration_scale(run.bodies, run.active, run.states.dydt.data());
    S heaviest = S(0);
    for (const int body : run.active.bodies) heaviest = real::max(heaviest, run.bodies.model.mass(body).mass_kg);
    const S unseen = round_off_acceleration(run.bodies, run.active);
    const S tiny_acceleration = real::max(S(1e6) * real::epsilon<S>() * size, unseen);
    const S tiny_N = real::max(S(1e5) * real::epsilon<S>() * size, unseen) * heaviest;
    for (Contact<S>& contact : run.active.contacts) {
      contact.warm_N = contact.largest_N = S(0);
      contact.warm_friction_N = contact.warm_couple_N_m = {};
    }
    if (run.active.count > 0)
      add_contact_forces(run.bodies, run.proximity, run.active, run.constraints, run.states.y.data(),
                         run.states.y.version, run.states.dydt.data());
    if (!laws_hold(run.proximity, run.active, run.constraints, tiny_N) &&
        !search_modes(run, t_s, tiny_N, tiny_acceleration)) {
      run.integration.free.rate(t_s, run.states.y.data(), run.states.dydt.data());
      solve_forces_gauss_seidel(run.bodies, run.proximity, run.active, run.constraints, run.states.dydt.data(), S(0));
      modes_from_forces(run.proximity, run.active, tiny_N, tiny_acceleration);
      release_cone_limits(run.proximity, run.active);
      count_active(run.active);
      run.constraints.solvable = true;
      if (run.active.count > 0)
        add_contact_forces(run.bodies, run.proximity, run.active, run.constraints, run.states.y.data(),
                           run.states.y.version, run.states.dydt.data());
    }
    clear_cone_marks(run.active);
    if (!run.constraints.solvable) {
      run.report.outcome = {
          Status::diverged, "atwood's +event found no contact forces that obey Coulomb's law", 0, 0, {}};
      return false;
    }
    // Of several contacts, forces are known to no more than that.
    const S coarse = run.active.contacts.size() > 1 ? real::sqrt(real::epsilon<S>()) * size : S(0);
    run.active.separation_acceleration = S(4) * real::max(tiny_acceleration, coarse);
    if (!check_forces(run, t_s, real::max(tiny_acceleration, coarse), real::max(tiny_N, coarse * heaviest)))
      return false;
    drop_separating(run.bodies, run.proximity, run.active, run.states, tiny_acceleration);
    count_active(run.active);
    list_contact_bodies(run.bodies, run.proximity, run.active);
  }
  ++run.bodies.model.system().epoch;
  run.active.reviewed_epoch = run.bodies.model.system().epoch;
  if (!report) return true;
  for (std::size_t i = 0; i < old.size(); ++i) {
    const int pair = run.proximity.candidates[old[i].candidate].pair;
    if (i > 0 && run.proximity.candidates[old[i - 1].candidate].pair == pair)
      continue;  // one event a pair; its contacts stand together
    report_mode_change(run.proximity, run.report, old[i], static_cast<PairState>(state[i]),
                       pair_state(run.bodies, run.proximity, run.active, pair), t_s);
  }
  return true;
}

#define ATWOOD_ACTIVE_SET(S)                                                                                  \
  template void report_event<S>(const Report&, EventKind, const ShapePair<S>&, const GapKinematics<S>&, bool, \
                                const Impulse<S>&, S);                                                        \
  template bool update_active_set<S>(EventRun<S>&, S, bool);
ATWOOD_ACTIVE_SET(float)
ATWOOD_ACTIVE_SET(double)
ATWOOD_ACTIVE_SET(long double)
#undef ATWOOD_ACTIVE_SET

}  // namespace atwood::event
