// Steps that follow slip near its onset and its end, where its direction turns fast.
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

// Change [m/s] of a surface velocity within within_s by the turning of the body's axes. Stages approximate it to second
// order only, and the slip with it.
template <class S> S frame_turning(const Bodies<S>& bodies, const StateBuffers<S>& states, int body, S within_s) {
  if (!bodies.moves[body] || !bodies.model.rotates(body)) return S(0);
  const Vec3<S> alpha =
      to_world(bodies.poses[body], load3(states.dydt.data() + bodies.model.offset(body) + kAtBodyRate));
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

// Across its slip, friction acts on a body as a damper of rate mu N k / |u|, stiff where slip is slow. Steps of at most
// 2 |u| / (mu N k) keep explicit methods stable, and still reach the end of the slip. At least h_s 2^-40.
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

// Where forces nearly balance at the onset of slip, slip grows from zero by far smaller steps than that. Until it is
// fast enough, it keeps within a step the direction at the step's end, as an implicit step would find it, so that the
// damper is not felt: of first order in the direction only. False: some slip decelerates.
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

// Slip that stops or reverses turns the faster the slower it is; about speed / braking is left for that. In a fixed
// fraction of this time the slip is smooth, down to round-off, and a fixed number of such segments takes a fixed
// fraction of its speed: few enough for a method of order 8. Slip with a constant direction needs none of this.
template <class S> S slip_limited_step(EventRun<S>& run, S t_s, S h_s, S left_s) {
  const auto set_onsets = [&](bool keep) {
    for (Contact<S>& contact : run.active.contacts) contact.slip_onset = keep || slip_is_zero(run.bodies, contact);
  };
  run.integration.use_fine_stepper = false;
  const S far = S(8) * h_s, stable = stable_step(run.bodies, run.proximity, run.active, far);
  const bool onset =
      std::any_of(run.active.contacts.begin(), run.active.contacts.end(), [&](const Contact<S>& contact) {
        return contact.active && !contact.at_cone_limit && slip_is_zero(run.bodies, contact);
      });
  if (stable >= far && !onset) {
    set_onsets(false);
    return left_s;
  }
  for (Contact<S>& contact : run.active.contacts)
    contact.slip_onset = contact.slip_onset || slip_is_zero(run.bodies, contact);
  const bool decelerates = !find_onset_directions(run.bodies, run.proximity, run.active, run.states,
                                                  t_s);  // with the directions of onset kept
  const SlipTurning turn = slip_turning(run.bodies, run.proximity, run.active, run.states, stable);
  set_onsets(false);
  if (turn.turns && turn.moves && (decelerates || !turn.balanced)) {
    run.integration.use_fine_stepper = true;
    return real::min(left_s, stable / S(8));
  }
  if (turn.moves && stable >= left_s) return left_s;
  set_onsets(true);
  if (!turn.moves)
    return turn.balanced ? left_s : real::min(left_s, S(0x1p-16) * h_s);  // along the friction that held it
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
