// Where rigid bodies and Coulomb's law have no contact force, or more than one (Painleve 1895).
//
// One point that slips along s:   (n . u)' = b + k N,   k = n . K n - mu n . K s,   b without the contact
//   k > 0            one answer: N = -b / k or, where b >= 0, none is needed
//   k <= 0, b < 0    none ("inconsistent"): an impact without collision ends the slip at once
//   k < 0,  b > 0    two ("indeterminate"): it lifts off, or is pressed on; nothing in the model chooses
// Several points at once: k N^2 becomes f . A f of their forces, A what forces make of accelerations.
//
// Sources: Painleve, C. R. Acad. Sci. 121 (1895) 112; Genot and Brogliato, Eur. J. Mech. A 18 (1999) 653; Champneys and
// Varkonyi, IMA J. Appl. Math. 81 (2016) 538.
#include <algorithm>
#include <limits>

#include "contact/event/rows.hpp"

namespace atwood::event {

namespace {

constexpr int kMostStrikesAtOnce = 16;

template <class S> Vec3<S> across(const Vec3<S>& v, const Vec3<S>& n) { return v - dot(v, n) * n; }

// What the contact asks of its two bodies' loads: without friction that follows the slip.
template <class S> Vec3<S> force_of(const Contact<S>& contact) {
  return contact.normal_N * contact.sight.normal + contact.friction_N;
}

template <class S> bool rubs(const EventRun<S>& run, const Contact<S>& contact) {
  return contact.carries && run.pairs[run.features[contact.feature].pair].friction > S(0) && !contact.of_balls;
}

// f . A f, of one contact or of all that are not alone. Friction of slip and the couple against rolling follow N: they
// press, but ask for nothing of their own.
template <class S> S answer_along_forces(EventRun<S>& run, const Contact<S>* alone, S& size) {
  const auto counts = [&](const Contact<S>& c) { return c.carries && (alone ? &c == alone : !c.alone); };
  for (const int body : run.contact_bodies) run.acceleration[body] = {};
  for (const Contact<S>& contact : run.contacts) {
    if (!counts(contact)) continue;
    const Row<S> row = load_row(run, contact, force_of(contact), contact.couple_N_m);
    for (int side = 0; side < 2; ++side) {
      if (row.body[side] < 0) continue;
      run.acceleration[row.body[side]].linear += row.answer[side].linear;
      run.acceleration[row.body[side]].angular += row.answer[side].angular;
    }
  }
  S sum = S(0);
  size = S(0);
  for (const Contact<S>& contact : run.contacts) {
    if (!counts(contact)) continue;
    const bool held = contact.mode == Mode::sticks, turned = contact.turning == Turning::held;
    const Vec3<S> force = held ? force_of(contact) : contact.normal_N * contact.sight.normal;
    const Row<S> row = load_row(run, contact, force, turned ? contact.couple_N_m : Vec3<S>{});
    for (int side = 0; side < 2; ++side) {
      if (row.body[side] < 0) continue;
      const S part = dot(row.row[side], run.acceleration[row.body[side]]);
      sum += part;
      size += real::abs(part);
    }
  }
  return sum;
}

template <class S> bool pressed_on(EventRun<S>& run, const Contact<S>* alone) {
  S size{};
  const S sum = answer_along_forces(run, alone, size);
  return sum < S(-256) * real::epsilon<S>() * size;
}

// Forces that obey the laws, next to lifting off.
template <class S> bool indeterminate(EventRun<S>& run) {
  bool together = false;
  for (const Contact<S>& contact : run.contacts) {
    if (!rubs(run, contact)) continue;
    if (!contact.alone) together = true;
    else if (contact.mode == Mode::slips && pressed_on(run, &contact)) return true;
  }
  return together && pressed_on<S>(run, nullptr);
}

// The pair whose points the forces, with all of them in run.dydt, do not keep from going in; -1: none.
template <class S> int inconsistent_pair(const EventRun<S>& run, S tiny_acceleration, S tiny_N) {
  int pair = -1;
  S worst = -tiny_acceleration;
  for (const Contact<S>& contact : run.contacts) {
    const int of = run.features[contact.feature].pair;
    if (contact.carries && contact.normal_N < -tiny_N && pair < 0) pair = of;
    if (contact.carries) continue;
    const S rises = normal_acceleration(run, contact, run.dydt.data());
    if (rises >= worst) continue;
    worst = rises;
    pair = of;
  }
  return pair;
}

// One point that stands for all points of the pair that touch: they move alike, as those of an edge do. False: they do
// not, or the body would turn about it.
template <class S> bool point_of_pair(const EventRun<S>& run, int pair, Contact<S>& one) {
  int count = 0;
  Vec3<S> along;
  for (const Contact<S>& contact : run.contacts) {
    if (run.features[contact.feature].pair != pair) continue;
    if (++count == 1) one = contact;
    if (count == 1) continue;
    if (run.features[contact.feature].knob_body != run.features[one.feature].knob_body) return false;
    if (norm(contact.sight.normal - one.sight.normal) > S(64) * real::epsilon<S>()) return false;
    if (norm(contact.u - one.u) > run.slip_round_off()) return false;
    along = contact.sight.x - one.sight.x;
  }
  if (count < 2) return count == 1;
  if (count > 2) return false;
  const Feature<S>& f = run.features[one.feature];
  const Vec3<S> from = run.poses[run.moves[f.knob_body] ? f.knob_body : f.surface_body].p - one.sight.x;
  const S part = dot(from, along) / dot(along, along);
  if (!(part > S(0) && part < S(1))) return false;
  one.sight.x += part * along;
  return true;
}

}  // namespace

template <class S> bool refuse_at(EventRun<S>& run, S t_s, const char* what) {
  run.outcome = {Status::unsupported,
                 "atwood's +event: at t = " + format_double(static_cast<double>(t_s)) + " s " + what,
                 0,
                 0,
                 {}};
  return false;
}

template <class S> void note_yield(Contact<S>& contact, S yield) {
  contact.least_yield = real::min(contact.least_yield, yield);
  contact.most_yield = real::max(contact.most_yield, yield);
}

template <class S> void forget_yields(EventRun<S>& run) {
  for (Contact<S>& contact : run.contacts) {
    contact.least_yield = std::numeric_limits<S>::infinity();
    contact.most_yield = S(0);
  }
}

// A 32nd of what a force may give at most.
template <class S> bool small_yield(const EventRun<S>& run, const Contact<S>& contact) {
  const Feature<S>& f = run.features[contact.feature];
  return contact.least_yield < (run.mobility[f.knob_body] + run.mobility[f.surface_body]) / S(32);
}

template <class S> bool near_singularity(const EventRun<S>& run) {
  return std::any_of(run.contacts.begin(), run.contacts.end(),
                     [&](const Contact<S>& contact) { return small_yield(run, contact); });
}

template <class S> bool keeps_off_singularity(const EventRun<S>& run) {
  return std::none_of(run.contacts.begin(), run.contacts.end(), [&](const Contact<S>& contact) {
    return contact.least_yield <= S(0) ||
           (small_yield(run, contact) && contact.most_yield > S(1.125) * contact.least_yield);
  });
}

template <class S> bool judge_forces(EventRun<S>& run, S t_s, S tiny_acceleration, S tiny_N) {
  run.inconsistent = -1;
  if (run.contacts.empty()) return true;
  run.inconsistent = inconsistent_pair(run, tiny_acceleration, tiny_N);
  if (run.inconsistent >= 0) return true;  // strike() follows
  if (indeterminate(run))
    return refuse_at(run, t_s,
                     "Coulomb's law has more than one answer (Painleve's indeterminate case): the contact can lift off "
                     "as well as be pressed on by its friction");
  return true;
}

template <class S> bool strike(EventRun<S>& run, S t_s) {
  const int p = run.inconsistent;
  run.inconsistent = -1;
  const ShapePair<S>& pair = run.pairs[p];
  if (!(t_s > run.struck_s)) ++run.strikes;
  else run.strikes = 0;
  run.struck_s = t_s;
  Contact<S> one;
  if (!(pair.friction > S(0)) || run.strikes > kMostStrikesAtOnce || !point_of_pair(run, p, one))
    return refuse_at(run, t_s, "no contact forces were found that obey Coulomb's law and keep the bodies apart");
  const Vec3<S>& n = one.sight.normal;
  const Feature<S>& f = run.features[one.feature];
  const Vec3<S> slip = across(one.u, n);
  const S speed = norm(slip);
  ImpactBody<S> surface = impact_body(run, f.surface_body, one.sight.x),
                knob = impact_body(run, f.knob_body, one.sight.x);
  const S held = mobility(surface, knob, n),
          k = speed > run.slip_round_off() ? held - pair.friction / speed * mobility(surface, knob, n, slip) : held;
  if (k > S(64) * real::epsilon<S>() * held)
    return refuse_at(run, t_s, "no contact forces were found that obey Coulomb's law and keep the bodies apart");
  if (run.options.restitution == Restitution::newton)
    return refuse_at(run, t_s,
                     "Coulomb's law has no contact force (Painleve's inconsistent case), and Newton's restitution no "
                     "answer for the impact without collision that follows; restitution=poisson and stronge have one");
  const ImpactLaw<S> law{pair.restitution, pair.friction, pair.rolling_friction_m, run.options.restitution};
  const Impulse<S> impulse = strike_without_collision(law, n, surface, knob);
  if (!impulse.finished || !(impulse.normal_N_s > S(0)))
    return refuse_at(run, t_s, "the impact without collision that Painleve's inconsistent case asks for has no end");
  if (run.moves[f.surface_body]) store_velocity(run, f.surface_body, surface.v_W, surface.w_W, run.y.data());
  if (run.moves[f.knob_body]) store_velocity(run, f.knob_body, knob.v_W, knob.w_W, run.y.data());
  report_event(run, EventKind::impact, pair, one.sight, f.knob_body == pair.a, impulse, t_s);
  return resolve_impacts(run, t_s);  // of those whom it has set in motion; then all contacts anew
}

#define ATWOOD_PAINLEVE(S)                                  \
  template bool judge_forces<S>(EventRun<S>&, S, S, S);     \
  template bool strike<S>(EventRun<S>&, S);                 \
  template bool refuse_at<S>(EventRun<S>&, S, const char*); \
  template void note_yield<S>(Contact<S>&, S);              \
  template void forget_yields<S>(EventRun<S>&);             \
  template bool near_singularity<S>(const EventRun<S>&);    \
  template bool keeps_off_singularity<S>(const EventRun<S>&);
ATWOOD_PAINLEVE(float)
ATWOOD_PAINLEVE(double)
ATWOOD_PAINLEVE(long double)
#undef ATWOOD_PAINLEVE

}  // namespace atwood::event
