// Configurations where rigid bodies and Coulomb's law have no contact force, or several (Painleve 1895).
//
// One point that slips along s:   (n . u)' = b + k N,   k = n . K n - mu n . K s,   b without the contact
//   k > 0            one solution: N = -b / k, or N = 0 where b >= 0
//   k <= 0, b < 0    none ("inconsistent"): an impact without collision ends the slip at once
//   k < 0,  b > 0    two ("indeterminate"): the contact separates, or its friction presses it on
// Several points: k N^2 becomes f . A f with their forces f and the Delassus operator A.
//
// Sources: Painleve, C. R. Acad. Sci. 121 (1895) 112; Genot and Brogliato, Eur. J. Mech. A 18 (1999) 653; Champneys and
// Varkonyi, IMA J. Appl. Math. 81 (2016) 538.
#include "contact/event/painleve.hpp"

#include <algorithm>
#include <limits>

#include "contact/event/contact_forces.hpp"
#include "contact/event/impacts.hpp"
#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

constexpr int kMaxPainleveImpacts = 16;

// The force on the feature's body.
template <class S> Vec3<S> force_of(const Contact<S>& contact) {
  return contact.normal_N * contact.kinematics.normal + contact.friction_N;
}

template <class S> bool may_be_indeterminate(const Proximity<S>& proximity, const Contact<S>& contact) {
  return contact.active && proximity.pairs[proximity.candidates[contact.candidate].pair].friction > S(0) &&
         !contact.between_spheres;
}

// f . A f of one contact, or of all that are not decoupled. Friction of slip and couples of rolling follow N: they act,
// but have no constraint of their own. `size`: the sum of the absolute values of its terms.
template <class S>
S delassus_form(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                ConstraintSystem<S>& constraints, const Contact<S>* single, S& size) {
  const auto counts = [&](const Contact<S>& c) { return c.active && (single ? &c == single : !c.decoupled); };
  for (const int body : active.bodies) constraints.acceleration[body] = {};
  for (const Contact<S>& contact : active.contacts) {
    if (!counts(contact)) continue;
    const ConstraintRow<S> row = row_of_load(bodies, proximity, contact, force_of(contact), contact.couple_N_m);
    for (int side = 0; side < 2; ++side) {
      if (row.body[side] < 0) continue;
      constraints.acceleration[row.body[side]].linear += row.response[side].linear;
      constraints.acceleration[row.body[side]].angular += row.response[side].angular;
    }
  }
  S sum = S(0);
  size = S(0);
  for (const Contact<S>& contact : active.contacts) {
    if (!counts(contact)) continue;
    const bool held = contact.mode == FrictionMode::stick, turned = contact.rolling == RollingMode::stick;
    const Vec3<S> force = held ? force_of(contact) : contact.normal_N * contact.kinematics.normal;
    const ConstraintRow<S> row =
        row_of_load(bodies, proximity, contact, force, turned ? contact.couple_N_m : Vec3<S>{});
    for (int side = 0; side < 2; ++side) {
      if (row.body[side] < 0) continue;
      const S part = dot(row.jacobian[side], constraints.acceleration[row.body[side]]);
      sum += part;
      size += real::abs(part);
    }
  }
  return sum;
}

template <class S>
bool friction_presses(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                      ConstraintSystem<S>& constraints, const Contact<S>* single) {
  S size{};
  const S sum = delassus_form(bodies, proximity, active, constraints, single, size);
  return sum < S(-256) * real::epsilon<S>() * size;
}

// Do the contacts have forces that obey the laws, besides separating?
template <class S>
bool indeterminate(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                   ConstraintSystem<S>& constraints) {
  bool together = false;
  for (const Contact<S>& contact : active.contacts) {
    if (!may_be_indeterminate(proximity, contact)) continue;
    if (!contact.decoupled) together = true;
    else if (contact.mode == FrictionMode::slip && friction_presses(bodies, proximity, active, constraints, &contact))
      return true;
  }
  return together && friction_presses<S>(bodies, proximity, active, constraints, nullptr);
}

// The pair whose contacts still approach with all forces in states.dydt; -1: none.
template <class S>
int inconsistent_pair(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                      const StateBuffers<S>& states, S tiny_acceleration, S tiny_N) {
  int pair = -1;
  S worst = -tiny_acceleration;
  for (const Contact<S>& contact : active.contacts) {
    const int of = proximity.candidates[contact.candidate].pair;
    if (contact.active && contact.normal_N < -tiny_N && pair < 0) pair = of;
    if (contact.active) continue;
    const S rises = normal_acceleration(bodies, proximity, contact, states.dydt.data());
    if (rises >= worst) continue;
    worst = rises;
    pair = of;
  }
  return pair;
}

// One point that is equivalent to all points of the pair that touch, because they move alike, as those of an edge do.
// False: there is none, or the body would turn about it.
template <class S>
bool point_of_pair(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active, int pair,
                   Contact<S>& one) {
  int count = 0;
  Vec3<S> along;
  for (const Contact<S>& contact : active.contacts) {
    if (proximity.candidates[contact.candidate].pair != pair) continue;
    if (++count == 1) one = contact;
    if (count == 1) continue;
    if (proximity.candidates[contact.candidate].feature_body != proximity.candidates[one.candidate].feature_body)
      return false;
    if (norm(contact.kinematics.normal - one.kinematics.normal) > S(64) * real::epsilon<S>()) return false;
    if (norm(contact.u - one.u) > bodies.slip_round_off()) return false;
    along = contact.kinematics.x - one.kinematics.x;
  }
  if (count < 2) return count == 1;
  if (count > 2) return false;
  const Candidate<S>& candidate = proximity.candidates[one.candidate];
  const Vec3<S> from =
      bodies.poses[bodies.moves[candidate.feature_body] ? candidate.feature_body : candidate.surface_body].p -
      one.kinematics.x;
  const S part = dot(from, along) / dot(along, along);
  if (!(part > S(0) && part < S(1))) return false;
  one.kinematics.x += part * along;
  return true;
}

}  // namespace

template <class S> void record_delassus(Contact<S>& contact, S delassus, S normal_N) {
  contact.min_delassus = real::min(contact.min_delassus, delassus);
  contact.max_delassus = real::max(contact.max_delassus, delassus);
  contact.min_normal_N = real::min(contact.min_normal_N, normal_N);
  contact.max_normal_N = real::max(contact.max_normal_N, normal_N);
}

template <class S> void reset_delassus_range(ActiveSet<S>& active) {
  for (Contact<S>& contact : active.contacts) {
    contact.min_delassus = std::numeric_limits<S>::infinity();
    contact.max_delassus = contact.min_normal_N = contact.max_normal_N = S(0);
  }
}

// Below 1/32 of the largest value that it may have?
template <class S>
bool delassus_near_zero(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact) {
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  return contact.min_delassus <
         (bodies.largest_inverse_mass[candidate.feature_body] + bodies.largest_inverse_mass[candidate.surface_body]) /
             S(32);
}

template <class S>
bool near_singularity(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active) {
  return std::any_of(active.contacts.begin(), active.contacts.end(),
                     [&](const Contact<S>& contact) { return delassus_near_zero(bodies, proximity, contact); });
}

template <class S>
bool delassus_is_resolved(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active) {
  return std::none_of(active.contacts.begin(), active.contacts.end(), [&](const Contact<S>& contact) {
    return contact.min_delassus <= S(0) ||
           (delassus_near_zero(bodies, proximity, contact) &&
            (contact.max_delassus > S(1.125) * contact.min_delassus || -contact.min_normal_N > contact.max_normal_N));
  });
}

template <class S> bool check_forces(EventRun<S>& run, S t_s, S tiny_acceleration, S tiny_N) {
  run.active.inconsistent = -1;
  if (run.active.contacts.empty()) return true;
  run.active.inconsistent =
      inconsistent_pair(run.bodies, run.proximity, run.active, run.states, tiny_acceleration, tiny_N);
  if (run.active.inconsistent >= 0) return true;  // impact_without_collision() follows
  if (indeterminate(run.bodies, run.proximity, run.active, run.constraints))
    return refuse_at(
        run.report, t_s,
        "Coulomb's law has more than one solution (Painleve's indeterminate case): the contact can separate, or "
        "be pressed on by its friction");
  return true;
}

template <class S> bool impact_without_collision(EventRun<S>& run, S t_s) {
  const int p = run.active.inconsistent;
  run.active.inconsistent = -1;
  const ShapePair<S>& pair = run.proximity.pairs[p];
  if (!(t_s > run.active.last_painleve_s)) ++run.active.painleve_impacts;
  else run.active.painleve_impacts = 0;
  run.active.last_painleve_s = t_s;
  Contact<S> one;
  if (run.active.painleve_impacts > kMaxPainleveImpacts)
    return refuse_at(run.report, t_s,
                     "more than " + std::to_string(kMaxPainleveImpacts) +
                         " impacts without collision at one instant (Painleve's inconsistent case)");
  if (!(pair.friction > S(0)) || !point_of_pair(run.bodies, run.proximity, run.active, p, one))
    return refuse_at(run.report, t_s, "no contact forces were found that obey Coulomb's law and keep the bodies apart");
  const Vec3<S>& n = one.kinematics.normal;
  const Candidate<S>& candidate = run.proximity.candidates[one.candidate];
  const Vec3<S> slip = perpendicular_part(one.u, n);
  const S speed = norm(slip);
  ImpactBody<S> surface = impact_body(run.bodies, candidate.surface_body, one.kinematics.x),
                feature = impact_body(run.bodies, candidate.feature_body, one.kinematics.x);
  const S without_slip = inverse_effective_mass(surface, feature, n),
          k = speed > run.bodies.slip_round_off()
                  ? without_slip - pair.friction / speed * inverse_effective_mass(surface, feature, n, slip)
                  : without_slip;
  if (k > S(64) * real::epsilon<S>() * without_slip)
    return refuse_at(run.report, t_s, "no contact forces were found that obey Coulomb's law and keep the bodies apart");
  if (run.options.restitution == Restitution::newton)
    return refuse_at(
        run.report, t_s,
        "Coulomb's law has no contact force (Painleve's inconsistent case), and restitution=newton does not "
        "define the impact without collision that follows; use restitution=poisson or stronge");
  const ImpactLaw<S> law{pair.restitution, pair.friction, pair.rolling_friction_m, run.options.restitution};
  const Impulse<S> impulse = collide_without_approach(law, n, surface, feature);
  if (!impulse.converged || !(impulse.normal_N_s > S(0)))
    return refuse_at(run.report, t_s, "the impact without collision of Painleve's inconsistent case did not end");
  if (run.bodies.moves[candidate.surface_body])
    store_velocity(run.bodies, candidate.surface_body, surface.v_W, surface.w_W, run.states.overwrite(run.states.y));
  if (run.bodies.moves[candidate.feature_body])
    store_velocity(run.bodies, candidate.feature_body, feature.v_W, feature.w_W, run.states.overwrite(run.states.y));
  report_event(run.report, EventKind::impact, pair, one.kinematics, candidate.feature_body == pair.a, impulse, t_s);
  return resolve_impacts(run, t_s);  // those that follow from it, then the active set
}

#define ATWOOD_PAINLEVE(S)                                                                       \
  template bool check_forces<S>(EventRun<S>&, S, S, S);                                          \
  template bool impact_without_collision<S>(EventRun<S>&, S);                                    \
  template void record_delassus<S>(Contact<S>&, S, S);                                           \
  template void reset_delassus_range<S>(ActiveSet<S>&);                                          \
  template bool near_singularity<S>(const Bodies<S>&, const Proximity<S>&, const ActiveSet<S>&); \
  template bool delassus_is_resolved<S>(const Bodies<S>&, const Proximity<S>&, const ActiveSet<S>&);
ATWOOD_PAINLEVE(float)
ATWOOD_PAINLEVE(double)
ATWOOD_PAINLEVE(long double)
#undef ATWOOD_PAINLEVE

}  // namespace atwood::event
