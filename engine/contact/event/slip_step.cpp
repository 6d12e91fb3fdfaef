// Slip near its end, or just after its onset: how fast its direction turns, and which steps follow it.
#include "contact/event/slip_step.hpp"

#include <algorithm>

#include "contact/event/contact_forces.hpp"
#include "contact/event/gauss_seidel.hpp"
#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

struct SlipTurning {
  bool turns = false;     // some slip, or a spin that drives it, changes direction within the time given
  bool moves = false;     // some slip is not zero
  bool balanced = false;  // some slip hardly changes: friction and what drives it nearly balance
};

// What the bodies' own frames turn under an angular acceleration that is not along their spin: a method's stages know
// such spins to the square of the step alone, and with them the slip.
template <class S> S frame_turning(const Bodies<S>& bodies, const StateBuffers<S>& states, int body, S within_s) {
  if (!bodies.moves[body] || !bodies.model.rotates(body)) return S(0);
  const Vec3<S> alpha = turned(bodies.poses[body], load3(states.dydt.data() + bodies.model.offset(body) + kAtBodyRate));
  return norm(cross(bodies.poses[body].w, alpha)) * within_s * bodies.bounding_radius[body];
}

template <class S>
SlipTurning slip_turning(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                         const StateBuffers<S>& states, S within_s) {
  const S straight = S(0x1p-4) * real::sqrt(real::epsilon<S>()), slow = S(0x1p-6);
  SlipTurning turn;
  for (const Contact<S>& contact : active.contacts) {
    if (!contact.active || contact.mode != FrictionMode::slip || contact.at_cone_limit) continue;
    const Candidate<S>& candidate = proximity.candidates[contact.candidate];
    const Vec3<S>&n = contact.kinematics.normal, &d = contact.slip_direction;
    const S friction = proximity.pairs[candidate.pair].friction * contact.normal_N;
    const S braking = -delassus_entry(bodies, proximity, contact, d, {}, -friction * d, {});
    const Vec3<S> u_dot = relative_acceleration(bodies, proximity, contact, states.dydt.data()),
                  across = u_dot - dot(u_dot, n) * n;
    const S aside = norm(across - dot(across, d) * d);
    const S spins = frame_turning(bodies, states, candidate.feature_body, within_s) +
                    frame_turning(bodies, states, candidate.surface_body, within_s);
    turn.turns = turn.turns || aside > straight * braking || spins > S(16) * straight * braking;
    turn.balanced = turn.balanced || norm(across) < slow * braking;
    turn.moves = turn.moves || contact.slip_speed > bodies.slip_round_off();
  }
  return turn;
}

template <class S> bool is_sliding(const Contact<S>& contact) {
  return contact.active && contact.mode == FrictionMode::slip && !contact.at_cone_limit;
}

// Across its slip a body feels friction as a damper of rate mu N k / |u|: stiff where slip is slow. Explicit methods
// are kept stable there by steps of at most 2 |u| / (mu N k), which still span the way to a stop. Slip that sets in
// starts from the floor.
template <class S>
S stable_step(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active, S h_s) {
  S longest = h_s;
  for (std::size_t i = 0; i < active.contacts.size();) {
    const std::size_t first = i;
    const Candidate<S>& candidate = proximity.candidates[active.contacts[i].candidate];
    const S friction = proximity.pairs[candidate.pair].friction;
    S speed = S(-1), loads = S(0);
    for (; i < active.contacts.size() && proximity.candidates[active.contacts[i].candidate].pair == candidate.pair;
         ++i) {
      const Contact<S>& contact = active.contacts[i];
      if (!is_sliding(contact)) continue;
      loads += contact.normal_N;
      if (slip_is_zero(bodies, contact)) continue;
      speed = speed < S(0) ? contact.slip_speed : real::min(speed, contact.slip_speed);
    }
    const S most =
        friction * loads *
        (bodies.largest_inverse_mass[candidate.feature_body] + bodies.largest_inverse_mass[candidate.surface_body]);
    if (speed < S(0) || S(2) * speed >= longest * most) continue;
    S braking = S(0);
    for (std::size_t k = first; k < i; ++k) {
      const Contact<S>& contact = active.contacts[k];
      if (!is_sliding(contact)) continue;
      const Vec3<S> force = contact.normal_N * (-friction * contact.slip_direction);
      braking -= delassus_entry(bodies, proximity, contact, contact.slip_direction, {}, force, {});
    }
    if (braking > S(0)) longest = real::min(longest, real::max(S(2) * speed / braking, h_s * S(0x1p-40)));
  }
  return longest;
}

// Where forces balance nearly as slip sets in, it grows from nothing by far smaller steps than that. Until it is fast
// enough, it keeps its direction within a step: that at the step's end, as an implicit step finds it, so that no damper
// is felt. Of first order in that direction alone. False: some slip slows down.
template <class S>
bool find_onset_directions(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                           StateBuffers<S>& states, S t_s) {
  bodies.model.system().rate(t_s, states.y.data(), states.dydt.data());
  for (const Contact<S>& contact : active.contacts) {
    if (!is_sliding(contact)) continue;
    const S friction = proximity.pairs[proximity.candidates[contact.candidate].pair].friction * contact.normal_N;
    const S braking =
        -delassus_entry(bodies, proximity, contact, contact.slip_direction, {}, -friction * contact.slip_direction, {});
    if (dot(contact.slip_direction, relative_acceleration(bodies, proximity, contact, states.dydt.data())) <
        -S(0x1p-10) * braking)
      return false;
  }
  return true;
}

}  // namespace

// The slip of a body that is stopped, or turned round, turns ever faster the slower it is: about speed / braking is
// left for that. In fixed parts of this time such a slip is smooth, down to round-off, and a fixed number of parts
// takes a fixed part of its speed: few enough for a method of order 8. Slip that keeps its direction needs none of
// this.
template <class S> S slip_limited_step(EventRun<S>& run, S t_s, S h_s, S left_s) {
  const auto keep_directions = [&](bool keep) {
    for (Contact<S>& contact : run.active.contacts) contact.slip_onset = keep || slip_is_zero(run.bodies, contact);
  };
  run.integration.use_fine_stepper = false;
  const S far = S(8) * h_s, stable = stable_step(run.bodies, run.proximity, run.active, far);
  const bool sets_in =
      std::any_of(run.active.contacts.begin(), run.active.contacts.end(), [&](const Contact<S>& contact) {
        return contact.active && !contact.at_cone_limit && slip_is_zero(run.bodies, contact);
      });
  if (stable >= far && !sets_in) {
    keep_directions(false);
    return left_s;
  }
  for (Contact<S>& contact : run.active.contacts)
    contact.slip_onset = contact.slip_onset || slip_is_zero(run.bodies, contact);
  const bool brakes = !find_onset_directions(run.bodies, run.proximity, run.active, run.states,
                                             t_s);  // what keeps its direction does so here
  const SlipTurning turn = slip_turning(run.bodies, run.proximity, run.active, run.states, stable);
  keep_directions(false);
  if (turn.turns && turn.moves && (brakes || !turn.balanced)) {
    run.integration.use_fine_stepper = true;
    return real::min(left_s, stable / S(8));
  }
  if (turn.moves && stable >= left_s) return left_s;
  keep_directions(true);
  if (!turn.moves) return turn.balanced ? left_s : real::min(left_s, S(0x1p-16) * h_s);  // along what held it until now
  if (!turn.turns) return left_s;
  run.integration.free.rate(t_s, run.states.y.data(), run.states.dydt.data());
  solve_forces_gauss_seidel(run.bodies, run.proximity, run.active, run.constraints, run.states.dydt.data(),
                            S(1) / left_s);
  return left_s;
}

#define ATWOOD_SLIP_STEP(S) template S slip_limited_step<S>(EventRun<S>&, S, S, S);
ATWOOD_SLIP_STEP(float)
ATWOOD_SLIP_STEP(double)
ATWOOD_SLIP_STEP(long double)
#undef ATWOOD_SLIP_STEP

}  // namespace atwood::event
