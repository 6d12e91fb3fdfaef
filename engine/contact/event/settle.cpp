// Contact forces at one instant by Gauss and Seidel, contact after contact on a round cone: right where forces must be
// chosen (which of several points lets go, along what slip sets in), slow, and so only where contacts change.
//
//   (n . u)' >= 0, N >= 0, one of them 0;   no slip: |T| <= mu N, and T against u' at the edge;   slip: T = -mu N u_t /
//   |u_t|
//
// Each turn solves one contact exactly for the others' present forces; Jourdan, Alart, Jean, Comp. Meth. Appl. Mech.
// Engng 155 (1998) 31.
#include <algorithm>

#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

template <class S> struct Settler {
  EventRun<S>& run;

  Vec3<S> relative(const Contact<S>& contact) const {
    const Feature<S>& f = run.features[contact.feature];
    const Pose<S>&k = run.poses[f.knob_body], &s = run.poses[f.surface_body];
    const Vec3<S>&x = contact.sight.x, &x_dot = contact.sight.x_dot;
    const Twist<S>&a = run.acceleration[f.knob_body], &b = run.acceleration[f.surface_body];
    return a.linear + cross(a.angular, x - k.p) + cross(k.w, x_dot - k.v) -
           (b.linear + cross(b.angular, x - s.p) + cross(s.w, x_dot - s.v));
  }
  Vec3<S> turning(const Contact<S>& contact) const {
    const Feature<S>& f = run.features[contact.feature];
    return run.acceleration[f.knob_body].angular - run.acceleration[f.surface_body].angular;
  }
  void apply(const Contact<S>& contact, const Vec3<S>& force, const Vec3<S>& couple) {
    const Row<S> row = load_row(run, contact, force, couple);
    for (int side = 0; side < 2; ++side) {
      if (row.body[side] < 0) continue;
      run.acceleration[row.body[side]].linear += row.answer[side].linear;
      run.acceleration[row.body[side]].angular += row.answer[side].angular;
    }
  }
};

template <class S> Vec3<S> shortened(const Vec3<S>& v, S most) {
  const S length = norm(v);
  return length > most ? (most / length) * v : v;
}

}  // namespace

template <class S> void settle_forces(EventRun<S>& run, const S* free_dydt, S rate_per_s) {
  std::fill(run.acceleration.begin(), run.acceleration.end(), Twist<S>{});
  for (const int body : run.contact_bodies) {
    if (!run.moves[body]) continue;
    const S* at = free_dydt + run.model.offset(body);
    run.acceleration[body].linear = load3(at + kAtVelocity);
    if (run.model.rotates(body)) run.acceleration[body].angular = turned(run.poses[body], load3(at + kAtBodyRate));
  }
  Settler<S> settler{run};
  for (Contact<S>& contact : run.contacts) {
    const Feature<S>& f = run.features[contact.feature];
    const ShapePair<S>& pair = run.pairs[f.pair];
    const Vec3<S>& n = contact.sight.normal;
    const bool warm = contact.sets_in && contact.mode == Mode::slips && !contact.waits;  // the forces as they are
    if (!warm) {
      contact.normal_N = S(0);
      contact.friction_N = {};
    }
    contact.couple_N_m = {};
    contact.along_W = n;
    contact.along_couple_W = {};
    if (contact.mode == Mode::slips && !contact.waits && !contact.sets_in)
      contact.along_W = n - pair.friction * contact.slip_direction;
    if (contact.turning == Turning::rolls) contact.along_couple_W = -pair.rolling_friction_m * contact.roll_direction;
    if (warm)
      settler.apply(contact, contact.normal_N * contact.along_W + contact.friction_N,
                    contact.normal_N * contact.along_couple_W);
    contact.mobility_n = effect_of_load(run, contact, n, {}, contact.along_W, contact.along_couple_W);
    const Vec3<S> axis = real::abs(n.x) < S(0.6) ? Vec3<S>{S(1), S(0), S(0)} : Vec3<S>{S(0), S(1), S(0)};
    Vec3<S> t = axis - dot(axis, n) * n;
    t = (S(1) / norm(t)) * t;
    const Vec3<S> t2 = cross(n, t);
    contact.mobility_t =
        real::max(effect_of_load(run, contact, t, {}, t, {}), effect_of_load(run, contact, t2, {}, t2, {})) +
        real::abs(effect_of_load(run, contact, t, {}, t2, {}));
    contact.mobility_c =
        real::max(effect_of_load(run, contact, {}, t, {}, t), effect_of_load(run, contact, {}, t2, {}, t2)) +
        real::abs(effect_of_load(run, contact, {}, t, {}, t2));
  }
  for (int sweep = 0; sweep < 5000; ++sweep) {
    S change = S(0), size = S(0);
    for (Contact<S>& contact : run.contacts) {
      const ShapePair<S>& pair = run.pairs[run.features[contact.feature].pair];
      const Vec3<S>& n = contact.sight.normal;
      const S lifts = dot(n, settler.relative(contact)) + dot(contact.u, contact.sight.normal_dot);
      const S normal = real::max(S(0), contact.normal_N - lifts / contact.mobility_n);
      settler.apply(contact, (normal - contact.normal_N) * contact.along_W,
                    (normal - contact.normal_N) * contact.along_couple_W);
      change = real::max(change, real::abs(normal - contact.normal_N));
      contact.normal_N = normal;
      size = real::max(size, normal);
      if (contact.mode != Mode::smooth && (contact.mode == Mode::sticks || contact.waits || contact.sets_in)) {
        const Vec3<S> u_dot = settler.relative(contact) + (contact.sets_in ? rate_per_s : S(0)) * contact.u,
                      across = u_dot - dot(u_dot, n) * n;
        const Vec3<S> friction =
            shortened(contact.friction_N - (S(1) / contact.mobility_t) * across, pair.friction * normal);
        settler.apply(contact, friction - contact.friction_N, {});
        change = real::max(change, norm(friction - contact.friction_N));
        contact.friction_N = friction;
      }
      if (contact.turning == Turning::held) {
        const Vec3<S> alpha = settler.turning(contact), across = alpha - dot(alpha, n) * n;
        const Vec3<S> couple =
            shortened(contact.couple_N_m - (S(1) / contact.mobility_c) * across, pair.rolling_friction_m * normal);
        settler.apply(contact, {}, couple - contact.couple_N_m);
        contact.couple_N_m = couple;
      }
    }
    if (!(change > S(2) * real::epsilon<S>() * size)) break;
  }
  for (Contact<S>& contact : run.contacts) {
    contact.u_dot = settler.relative(contact);
    contact.alpha = settler.turning(contact);
    if (!contact.sets_in || contact.mode != Mode::slips || contact.waits) continue;
    const Vec3<S> u_end = contact.u_dot + rate_per_s * contact.u,
                  across = u_end - dot(u_end, contact.sight.normal) * contact.sight.normal;
    const S braking = run.pairs[run.features[contact.feature].pair].friction * contact.normal_N * contact.mobility_t;
    if (norm(across) > S(0x1p-16) * braking) contact.slip_direction = (S(1) / norm(across)) * across;
  }
}

template void settle_forces<float>(EventRun<float>&, const float*, float);
template void settle_forces<double>(EventRun<double>&, const double*, double);
template void settle_forces<long double>(EventRun<long double>&, const long double*, long double);

}  // namespace atwood::event
