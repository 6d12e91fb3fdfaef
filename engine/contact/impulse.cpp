#include "contact/impulse.hpp"

namespace atwood {

namespace {

template <class S> Vec3<S> times(const Vec3<S> (&row)[3], const Vec3<S>& v) { return {dot(row[0], v), dot(row[1], v), dot(row[2], v)}; }

// 1/m + d . (I^-1 (r x d)) x r  =  1/m + (r x d) . I^-1 (r x d)
template <class S> S own_mobility(const ImpactBody<S>& body, const Vec3<S>& d) {
  const Vec3<S> arm = cross(body.r_W, d);
  const S angular = dot(arm, times(body.I_inverse_W_row, arm));
  return body.inverse_mass_per_kg + angular;
}

template <class S> void push_one(ImpactBody<S>& body, const Vec3<S>& impulse_W) {
  body.v_W += body.inverse_mass_per_kg * impulse_W;
  body.w_W += times(body.I_inverse_W_row, cross(body.r_W, impulse_W));
}

}  // namespace

template <class S> Vec3<S> velocity_between(const ImpactBody<S>& a, const ImpactBody<S>& b) {
  return (b.v_W + cross(b.w_W, b.r_W)) - (a.v_W + cross(a.w_W, a.r_W));
}

template <class S> S mobility(const ImpactBody<S>& a, const ImpactBody<S>& b, const Vec3<S>& d) {
  return own_mobility(a, d) + own_mobility(b, d);
}

template <class S> void push(ImpactBody<S>& a, ImpactBody<S>& b, const Vec3<S>& direction, S impulse_N_s) {
  push_one(a, -impulse_N_s * direction);
  push_one(b, impulse_N_s * direction);
}

template <class S>
Impulse<S> collide(const ImpactLaw<S>& law, const Vec3<S>& normal, ImpactBody<S>& a, ImpactBody<S>& b) {
  Impulse<S> impulse;
  const Vec3<S> before = velocity_between(a, b);
  impulse.vn_before_m_per_s = impulse.vn_after_m_per_s = dot(before, normal);
  if (!(impulse.vn_before_m_per_s < S(0))) return impulse;

  const S j_n = -(S(1) + law.restitution) * impulse.vn_before_m_per_s / mobility(a, b, normal);
  impulse.normal_N_s = j_n;
  const Vec3<S> slip = before - dot(before, normal) * normal;
  const S slip_speed = norm(slip);
  push(a, b, normal, j_n);
  if (law.friction > S(0) && slip_speed > S(0)) {
    const Vec3<S> along = (S(1) / slip_speed) * slip;
    const S to_stick = slip_speed / mobility(a, b, along);
    const S j_t = real::min(law.friction * j_n, to_stick);
    push(a, b, along, -j_t);
    impulse.tangential_N_s = j_t;
  }
  impulse.vn_after_m_per_s = dot(velocity_between(a, b), normal);
  return impulse;
}

#define ATWOOD_IMPULSE(S)                                                                                          \
  template Impulse<S> collide<S>(const ImpactLaw<S>&, const Vec3<S>&, ImpactBody<S>&, ImpactBody<S>&);             \
  template void push<S>(ImpactBody<S>&, ImpactBody<S>&, const Vec3<S>&, S);                                        \
  template Vec3<S> velocity_between<S>(const ImpactBody<S>&, const ImpactBody<S>&);                                \
  template S mobility<S>(const ImpactBody<S>&, const ImpactBody<S>&, const Vec3<S>&);
ATWOOD_IMPULSE(float)
ATWOOD_IMPULSE(double)
ATWOOD_IMPULSE(long double)
#undef ATWOOD_IMPULSE

}  // namespace atwood
