// The active set: first all contacts are active, and those without slip stick. If the forces of that linear solve obey
// the laws, they are the solution. Else contacts that pull are released, those beyond their cone slip along the
// friction that held them, and so on while the result is consistent. If that fails, forces are found by projected
// Gauss-Seidel iteration (gauss_seidel.hpp), and modes follow from them; redundant contacts may stand at their cones'
// limits while others hold the body.
#include "contact/event/modes.hpp"

#include <algorithm>

#include "contact/event/contact_forces.hpp"

namespace atwood::event {

template <class S>
void modes_from_velocities(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active) {
  for (Contact<S>& contact : active.contacts)
    contact.slip_speed = norm(perpendicular_part(contact.u, contact.kinematics.normal));
  for (Contact<S>& contact : active.contacts) {
    const int p = proximity.candidates[contact.candidate].pair;
    const ShapePair<S>& pair = proximity.pairs[p];
    const Vec3<S> slip = perpendicular_part(contact.u, contact.kinematics.normal),
                  roll = perpendicular_part(contact.w, contact.kinematics.normal);
    const S speed = norm(slip), rolling = norm(roll), still = bodies.slip_round_off();
    // Vertices of one body stop together: where one has stopped, the others' round-off may be somewhat larger.
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
      contact.rolling = RollingMode::stick;
    }
    contact.reached_rolling_bound = false;
  }
}

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
           return contact.rolling != RollingMode::stick ||
                  norm(contact.couple_N_m) <= pair.rolling_friction_m * contact.normal_N;
         });
}

namespace {

constexpr int kMaxModeIterations = 12;  // after them projected Gauss-Seidel solves the forces, which is reported

// Deactivates contacts with a tensile normal force, or none. If there are none of these, changes contacts beyond their
// friction cone to slip, and those beyond the rolling bound to roll. True: some contact changed.
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
    if (contact.rolling == RollingMode::stick && turned > pair.rolling_friction_m * contact.normal_N) {
      contact.rolling = RollingMode::roll;
      contact.roll_direction = (S(-1) / turned) * contact.couple_N_m;
      changed = true;
    }
  }
  return changed;
}

// True if the acceleration `onset` points along `direction`, or is zero; at_cone_limit is set if it is zero.
template <class S> bool accelerates_along(const Vec3<S>& onset, const Vec3<S>& direction, S tiny, bool& at_cone_limit) {
  const S along = dot(onset, direction), aside = norm(onset - along * direction);
  at_cone_limit = !(norm(onset) > tiny);
  return at_cone_limit || (along > S(0) && aside <= real::sqrt(real::epsilon<S>()) * along + tiny);
}

// Activates a contact that does not separate. Where all contacts of its pair would pull if they stuck, they slip: with
// large friction the end of a rod may be pressed although sticking would need a tensile force.
template <class S>
void reactivate(const Bodies<S>& bodies, const Proximity<S>& proximity, const StateBuffers<S>& states,
                bool pair_released, S tiny_acceleration, Contact<S>& contact) {
  contact.active = true;
  if (!pair_released || contact.mode != FrictionMode::stick) return;
  const Vec3<S> onset = perpendicular_part(relative_acceleration(bodies, proximity, contact, states.dydt.data()),
                                           contact.kinematics.normal);
  const S size = norm(onset);
  if (!(size > tiny_acceleration)) return;
  contact.mode = FrictionMode::slip;
  contact.slip_onset = true;  // its direction is that of the acceleration, since the velocity is round-off
  contact.slip_direction = (S(1) / size) * onset;
}

// True if inactive contacts separate and slipping ones accelerate along their slip direction. Changes at_cone_limit;
// reactivates contacts that do not separate (`reactivated`, returns true: solve again).
template <class S>
bool released_consistent(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                         const StateBuffers<S>& states, S tiny_acceleration, bool& reactivated) {
  reactivated = false;
  const auto pair_of = [&](const Contact<S>& contact) { return proximity.candidates[contact.candidate].pair; };
  for (std::size_t first = 0, end; first < active.contacts.size(); first = end) {  // contacts of one pair
    bool released = true;
    for (end = first; end < active.contacts.size() && pair_of(active.contacts[end]) == pair_of(active.contacts[first]);
         ++end)
      released = released && !active.contacts[end].active;
    for (std::size_t i = first; i < end; ++i) {
      Contact<S>& contact = active.contacts[i];
      if (contact.active || !(normal_acceleration(bodies, proximity, contact, states.dydt.data()) < -tiny_acceleration))
        continue;
      reactivate(bodies, proximity, states, released, tiny_acceleration, contact);
      reactivated = true;
    }
  }
  if (reactivated) return true;
  for (Contact<S>& contact : active.contacts) {
    if (!contact.active) continue;
    const Vec3<S>& n = contact.kinematics.normal;
    bool at_cone_limit = false;
    if (contact.mode == FrictionMode::slip && !(contact.slip_speed > bodies.slip_round_off())) {
      const Vec3<S> onset =
          perpendicular_part(relative_acceleration(bodies, proximity, contact, states.dydt.data()), n);
      if (!accelerates_along(onset, contact.slip_direction, tiny_acceleration, at_cone_limit)) return false;
      contact.at_cone_limit = at_cone_limit;
    }
    const S radius = proximity.pairs[proximity.candidates[contact.candidate].pair].bounding_radii;
    if (contact.rolling == RollingMode::roll && !(contact.roll_speed * radius > bodies.slip_round_off())) {
      const Vec3<S> onset =
          radius * perpendicular_part(relative_angular_acceleration(bodies, proximity, contact, states.dydt.data()), n);
      if (!accelerates_along(onset, contact.roll_direction, tiny_acceleration, at_cone_limit) || at_cone_limit)
        return false;
    }
  }
  return true;
}

}  // namespace

template <class S> bool search_modes(EventRun<S>& run, S t_s, const Tolerances<S>& tolerances) {
  if (std::any_of(run.active.contacts.begin(), run.active.contacts.end(),
                  [](const Contact<S>& c) { return c.at_cone_limit; }))
    return false;
  run.active.kept = run.active.contacts;
  for (int iteration = 0; iteration < kMaxModeIterations && run.constraints.solvable; ++iteration) {
    if (release_violated(run.proximity, run.active, tolerances.force_N)) {
      evaluate_rates(run, t_s);
      continue;
    }
    bool reactivated = false;
    if (!released_consistent(run.bodies, run.proximity, run.active, run.states, tolerances.acceleration, reactivated))
      break;
    if (!reactivated) return true;
    evaluate_rates(run, t_s);
  }
  run.active.contacts.swap(run.active.kept);
  run.constraints.solvable = true;
  return false;
}

template <class S>
void modes_from_forces(const Proximity<S>& proximity, ActiveSet<S>& active, S tiny_N, S tiny_acceleration) {
  for (Contact<S>& contact : active.contacts) {
    const ShapePair<S>& pair = proximity.pairs[proximity.candidates[contact.candidate].pair];
    const Vec3<S>& n = contact.kinematics.normal;
    contact.active = contact.normal_N > tiny_N;
    contact.warm_start_N = contact.normal_N;
    contact.largest_N = real::max(contact.largest_N, contact.normal_N);
    if (contact.mode != FrictionMode::frictionless && (contact.mode == FrictionMode::stick || contact.at_cone_limit)) {
      const Vec3<S> onset = perpendicular_part(contact.u_dot, n);
      const S size = norm(onset), held = norm(contact.friction_N);
      contact.mode = FrictionMode::stick;
      contact.at_cone_limit = false;
      if (size > tiny_acceleration) {
        contact.mode = FrictionMode::slip;
        contact.slip_direction = (S(1) / size) * onset;
      } else if (held > S(0) && (contact.reached_cone || held > pair.friction * contact.normal_N - tiny_N)) {
        contact.mode = FrictionMode::slip;
        contact.at_cone_limit = true;
        contact.slip_direction = (S(-1) / held) * contact.friction_N;
      }
    }
    if (contact.rolling == RollingMode::stick) {
      const Vec3<S> onset = perpendicular_part(contact.alpha, n);
      const S size = norm(onset);
      if (size * pair.bounding_radii > tiny_acceleration) {
        contact.rolling = RollingMode::roll;
        contact.roll_direction = (S(1) / size) * onset;
      }
    }
  }
}

template <class S> void release_cone_limits(const Proximity<S>& proximity, ActiveSet<S>& active) {
  for (Contact<S>& contact : active.contacts) {
    if (!contact.at_cone_limit) continue;
    const int pair = proximity.candidates[contact.candidate].pair;
    contact.at_cone_limit = std::any_of(active.contacts.begin(), active.contacts.end(), [&](const Contact<S>& other) {
      return other.active && other.mode == FrictionMode::stick && proximity.candidates[other.candidate].pair == pair;
    });
  }
}

#define ATWOOD_MODES(S)                                                                                \
  template void modes_from_velocities<S>(const Bodies<S>&, const Proximity<S>&, ActiveSet<S>&);        \
  template bool laws_hold<S>(const Proximity<S>&, const ActiveSet<S>&, const ConstraintSystem<S>&, S); \
  template bool search_modes<S>(EventRun<S>&, S, const Tolerances<S>&);                                \
  template void modes_from_forces<S>(const Proximity<S>&, ActiveSet<S>&, S, S);                        \
  template void release_cone_limits<S>(const Proximity<S>&, ActiveSet<S>&);
ATWOOD_MODES(float)
ATWOOD_MODES(double)
ATWOOD_MODES(long double)
#undef ATWOOD_MODES

}  // namespace atwood::event
