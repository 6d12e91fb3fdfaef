// Slip near its end, or just after it set in: how fast its direction turns.
#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

// What the bodies' own frames turn under an angular acceleration that is not along their spin: a method's stages know
// such spins to the square of the step alone, and with them the slip.
template <class S> S turning_aside(const EventRun<S>& run, int body, S within_s) {
  if (!run.moves[body] || !run.model.rotates(body)) return S(0);
  const Vec3<S> alpha = turned(run.poses[body], load3(run.dydt.data() + run.model.offset(body) + kAtBodyRate));
  return norm(cross(run.poses[body].w, alpha)) * within_s * run.reach[body];
}

}  // namespace

template <class S> SlipTurn slip_turn(const EventRun<S>& run, S within_s) {
  const S straight = S(0x1p-4) * real::sqrt(real::epsilon<S>()), slow = S(0x1p-6);
  SlipTurn turn;
  for (const Contact<S>& contact : run.contacts) {
    if (!contact.carries || contact.mode != Mode::slips || contact.waits) continue;
    const Feature<S>& feature = run.features[contact.feature];
    const Vec3<S>&n = contact.sight.normal, &d = contact.slip_direction;
    const S friction = run.pairs[feature.pair].friction * contact.normal_N;
    const S braking = -effect_of_load(run, contact, d, {}, -friction * d, {});
    const Vec3<S> u_dot = relative_acceleration(run, contact, run.dydt.data()), across = u_dot - dot(u_dot, n) * n;
    const S aside = norm(across - dot(across, d) * d);
    const S spins =
        turning_aside(run, feature.knob_body, within_s) + turning_aside(run, feature.surface_body, within_s);
    turn.turns = turn.turns || aside > straight * braking || spins > S(16) * straight * braking;
    turn.slow = turn.slow || norm(across) < slow * braking;
    turn.moves = turn.moves || contact.slip_speed > run.slip_round_off();
  }
  return turn;
}

template SlipTurn slip_turn<float>(const EventRun<float>&, float);
template SlipTurn slip_turn<double>(const EventRun<double>&, double);
template SlipTurn slip_turn<long double>(const EventRun<long double>&, long double);

}  // namespace atwood::event
