#include "contact/impulse.hpp"

#include "contact/slip_path.hpp"

namespace atwood {

namespace {

// c . d / m + c . (I^-1 (r x d)) x r  =  c . d / m + (r x c) . I^-1 (r x d)
template <class S> S own_inverse_mass(const ImpactBody<S>& body, const Vec3<S>& c, const Vec3<S>& d) {
  const Vec3<S> arm = cross(body.r_W, c);
  const S angular = dot(arm, times(body.I_inverse_W_row, cross(body.r_W, d)));
  return body.inverse_mass_per_kg * dot(c, d) + angular;
}

template <class S> void apply_to_body(ImpactBody<S>& body, const Vec3<S>& impulse_W) {
  body.v_W += body.inverse_mass_per_kg * impulse_W;
  body.w_W += times(body.I_inverse_W_row, cross(body.r_W, impulse_W));
}

// Is K diagonal in the frame of the slip, the direction across it, and the normal?
template <class S>
bool decoupled(const ImpactBody<S>& a, const ImpactBody<S>& b, const Vec3<S> (&axis)[3], S (&K)[3][3]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) K[i][j] = K[j][i] = inverse_effective_mass(a, b, axis[i], axis[j]);
  const S round_off = S(32) * real::epsilon<S>() * (K[0][0] + K[1][1] + K[2][2]);
  return real::abs(K[0][1]) <= round_off && real::abs(K[0][2]) <= round_off && real::abs(K[1][2]) <= round_off;
}

// The couple against rolling, |c| <= delta p, and friction, |j| <= mu p, that together leave the least kinetic energy:
// block coordinate descent, each in turn with the other fixed, so that energy falls in every iteration. Changes a, b
// and the size of the friction impulse, tangential_N_s. Converged: the couple changed by at most 2 eps of itself, which
// is the residual.
template <class S>
SolveReport resist_rolling(const ImpactLaw<S>& law, const Vec3<S>& n, S p, ImpactBody<S>& a, ImpactBody<S>& b,
                           S& tangential_N_s, const Vec3<S>& along) {
  Vec3<S> friction = -tangential_N_s * along, couple{};
  constexpr int max_iterations = 200;
  int iteration = 0;
  S change{}, size{};
  for (; iteration < max_iterations; ++iteration) {
    const Vec3<S> w = b.w_W - a.w_W, rolling = w - dot(w, n) * n;
    const S speed = norm(rolling);
    if (!(speed > S(0))) break;
    const Vec3<S> axis = (S(1) / speed) * rolling;
    const S inverse_inertia = dot(axis, times(a.I_inverse_W_row, axis)) + dot(axis, times(b.I_inverse_W_row, axis));
    if (!(inverse_inertia > S(0))) break;
    const Vec3<S> next = shortened(couple - (S(1) / inverse_inertia) * rolling, law.rolling_friction_m * p);
    change = norm(next - couple);
    apply_couple(a, b, next - couple);
    couple = next;
    const Vec3<S> u = relative_velocity(a, b), slip = u - dot(u, n) * n;
    const S slip_speed = norm(slip);
    if (slip_speed > S(0)) {
      const S to_stick = slip_speed / inverse_effective_mass(a, b, (S(1) / slip_speed) * slip);
      const Vec3<S> next_friction = shortened(friction - (to_stick / slip_speed) * slip, law.friction * p);
      apply_impulse(a, b, next_friction - friction, S(1));
      friction = next_friction;
    }
    size = norm(couple);
    if (change <= S(2) * real::epsilon<S>() * size) break;
  }
  tangential_N_s = norm(friction);
  const bool converged = iteration < max_iterations;
  return {converged ? iteration + 1 : iteration, static_cast<double>(change > S(0) ? change / size : S(0)),
          converged ? SolveEnd::converged : SolveEnd::capped};
}

// Applies the impulse of the whole slip path, then the couple against rolling. Axes: the slip, across it, the normal.
template <class S>
void apply_slip_path(const ImpactLaw<S>& law, const S (&K)[3][3], const S (&u0)[3], const Vec3<S> (&axis)[3],
                     ImpactBody<S>& a, ImpactBody<S>& b, Impulse<S>& impulse) {
  const SlipPath<S> path = slip_path(law, K, u0);
  const auto& J = path.impulse_N_s;
  apply_impulse(a, b, J[0] * axis[0] + J[1] * axis[1] + J[2] * axis[2], S(1));
  impulse.normal_N_s = J[2];
  impulse.tangential_N_s = real::sqrt(J[0] * J[0] + J[1] * J[1]);
  add_solve(path.solve, impulse);
  if (law.rolling_friction_m > S(0)) {
    const ImpactLaw<S> rolling_only{law.restitution, S(0), law.rolling_friction_m, law.hypothesis};
    S none{};
    add_solve(resist_rolling(rolling_only, axis[2], J[2], a, b, none, axis[0]), impulse);
  }
  impulse.vn_after_m_per_s = dot(relative_velocity(a, b), axis[2]);
}

}  // namespace

template <class S> void add_solve(const SolveReport& solve, Impulse<S>& impulse) {
  if (!impulse.converged) return;
  impulse.solve = solve;
  impulse.converged = solve.ended != SolveEnd::capped;
}

template <class S> Vec3<S> relative_velocity(const ImpactBody<S>& a, const ImpactBody<S>& b) {
  return (b.v_W + cross(b.w_W, b.r_W)) - (a.v_W + cross(a.w_W, a.r_W));
}

template <class S>
S inverse_effective_mass(const ImpactBody<S>& a, const ImpactBody<S>& b, const Vec3<S>& c, const Vec3<S>& d) {
  return own_inverse_mass(a, c, d) + own_inverse_mass(b, c, d);
}
template <class S> S inverse_effective_mass(const ImpactBody<S>& a, const ImpactBody<S>& b, const Vec3<S>& d) {
  return inverse_effective_mass(a, b, d, d);
}

template <class S> void apply_impulse(ImpactBody<S>& a, ImpactBody<S>& b, const Vec3<S>& direction, S impulse_N_s) {
  apply_to_body(a, -impulse_N_s * direction);
  apply_to_body(b, impulse_N_s * direction);
}

template <class S> void apply_couple(ImpactBody<S>& a, ImpactBody<S>& b, const Vec3<S>& couple_N_m_s) {
  a.w_W -= times(a.I_inverse_W_row, couple_N_m_s);
  b.w_W += times(b.I_inverse_W_row, couple_N_m_s);
}

template <class S>
Impulse<S> collide(const ImpactLaw<S>& law, const Vec3<S>& normal, ImpactBody<S>& a, ImpactBody<S>& b) {
  Impulse<S> impulse;
  const Vec3<S> before = relative_velocity(a, b);
  impulse.vn_before_m_per_s = impulse.vn_after_m_per_s = dot(before, normal);
  if (!(impulse.vn_before_m_per_s < S(0))) return impulse;

  const S j_n = -(S(1) + law.restitution) * impulse.vn_before_m_per_s / inverse_effective_mass(a, b, normal);
  impulse.normal_N_s = j_n;
  const Vec3<S> slip = before - dot(before, normal) * normal;
  const S slip_speed = norm(slip);
  const Vec3<S> along = slip_speed > S(0) ? (S(1) / slip_speed) * slip : any_tangent(normal);
  S K[3][3];
  if (law.friction > S(0)) {
    const Vec3<S> axis[3] = {along, cross(normal, along), normal};
    if (!decoupled(a, b, axis, K)) {
      const S u0[3] = {slip_speed, S(0), impulse.vn_before_m_per_s};
      apply_slip_path(law, K, u0, axis, a, b, impulse);
      return impulse;
    }
  }
  apply_impulse(a, b, normal, j_n);
  if (law.friction > S(0) && slip_speed > S(0)) {
    const S to_stick = slip_speed / inverse_effective_mass(a, b, along);
    const S j_t = real::min(law.friction * j_n, to_stick);
    apply_impulse(a, b, along, -j_t);
    impulse.tangential_N_s = j_t;
  }
  if (law.rolling_friction_m > S(0))
    add_solve(resist_rolling(law, normal, j_n, a, b, impulse.tangential_N_s, along), impulse);
  impulse.vn_after_m_per_s = dot(relative_velocity(a, b), normal);
  return impulse;
}

template <class S>
Impulse<S> collide_without_approach(const ImpactLaw<S>& law, const Vec3<S>& normal, ImpactBody<S>& a,
                                    ImpactBody<S>& b) {
  Impulse<S> impulse;
  const Vec3<S> u = relative_velocity(a, b), slip = u - dot(u, normal) * normal;
  const S speed = norm(slip);
  if (!(speed > S(0)) || !(law.friction > S(0)) || law.hypothesis == Restitution::newton) return impulse;
  const Vec3<S> along = (S(1) / speed) * slip, axis[3] = {along, cross(normal, along), normal};
  S K[3][3];
  if (decoupled(a, b, axis, K)) return impulse;
  const S u0[3] = {speed, S(0), S(0)};
  apply_slip_path(law, K, u0, axis, a, b, impulse);
  return impulse;
}

#define ATWOOD_IMPULSE(S)                                                                              \
  template void add_solve<S>(const SolveReport&, Impulse<S>&);                                         \
  template Impulse<S> collide<S>(const ImpactLaw<S>&, const Vec3<S>&, ImpactBody<S>&, ImpactBody<S>&); \
  template Impulse<S> collide_without_approach<S>(const ImpactLaw<S>&, const Vec3<S>&, ImpactBody<S>&, \
                                                  ImpactBody<S>&);                                     \
  template void apply_impulse<S>(ImpactBody<S>&, ImpactBody<S>&, const Vec3<S>&, S);                   \
  template void apply_couple<S>(ImpactBody<S>&, ImpactBody<S>&, const Vec3<S>&);                       \
  template Vec3<S> relative_velocity<S>(const ImpactBody<S>&, const ImpactBody<S>&);                   \
  template S inverse_effective_mass<S>(const ImpactBody<S>&, const ImpactBody<S>&, const Vec3<S>&);    \
  template S inverse_effective_mass<S>(const ImpactBody<S>&, const ImpactBody<S>&, const Vec3<S>&, const Vec3<S>&);
ATWOOD_IMPULSE(float)
ATWOOD_IMPULSE(double)
ATWOOD_IMPULSE(long double)
#undef ATWOOD_IMPULSE

}  // namespace atwood
