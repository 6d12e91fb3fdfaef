// Rotation of a free body: body rates by Jacobi's elliptic functions (Jacobi 1849), attitude by an elliptic integral of
// the third kind; the form of R. van Zon and J. Schofield, J. Comput. Phys. 225 (2007) 145, with Carlson's integrals in
// place of theta functions. Principal axes are ordered so that axis 3, of largest or smallest moment, is the one that
// the angular momentum circles in the body:
//   w1 = a1 cn u, w2 = a2 sn u, w3 = a3 dn u,   u = lambda t + u0
#include <algorithm>

#include "closed_form/elliptic.hpp"
#include "closed_form/principal_axes.hpp"
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

// Spin about an axis on which the torque-free rate stays: q = q0 exp(w t / 2).
template <class S> RotationAt<S> steady(const Quat<S>& q0, const Vec<S>& w) {
  const S rate = norm(w);
  if (rate == 0) return [=](S) { return Rotation<S>{q0, w}; };
  return [=](S t) { return Rotation<S>{q0 * turn((1 / rate) * w, rate * t), w}; };
}

template <class S> struct Top {
  Quat<S> q_BP{1, 0, 0, 0};  // principal axes to body axes, in Jacobi's order
  std::array<S, 3> I{};
  Quat<S> q0_WP{1, 0, 0, 0};
  S a1{}, a2{}, a3{}, lambda{}, u0{}, kc{};
  Jacobi<S> start;
  S L{}, third0{};  // third0, start_WP: what is the same at every instant
  Vec<S> axis_W{};  // of the angular momentum
  Quat<S> start_WP{1, 0, 0, 0};

  // sn^3 R_J(cn^2, dn^2, 1, 1 - n sn^2), continued over half periods: (3/n) (Pi(n; phi) - F(phi)).
  S third_kind(const Jacobi<S>& at) const {
    const S sn = at.sn;
    const S part = sn * sn * sn * carlson_rj(at.cn * at.cn, at.dn * at.dn, S(1), 1 - excess() * sn * sn);
    if (at.halves == 0) return part;
    return part + 2 * at.halves * carlson_rj(S(0), kc * kc, S(1), 1 - excess());
  }
  // n = I3 (I2 - I1) / (I1 (I2 - I3)) <= 0
  S excess() const { return I[2] * (I[1] - I[0]) / (I[0] * (I[1] - I[2])); }

  // The direction of L in principal axes is Rz(azimuth) Ry(polar) z; the azimuth follows the amplitude without a jump.
  Quat<S> to_momentum(const Jacobi<S>& at) const {
    const S l1 = I[0] * a1, l2 = I[1] * a2, side = l2 < 0 ? -1 : 1, pairs = floor(at.halves / 2);
    const bool odd = at.halves != 2 * pairs;
    const S x = (odd ? -1 : 1) * l1 * at.cn, y = (odd ? -1 : 1) * l2 * at.sn;
    const S turns = odd && at.sn >= 0 ? pairs + 1 : pairs;
    const S azimuth = atan2(y, x) + side * 2 * turns * pi<S>();
    const S polar = atan2(sqrt(x * x + y * y), I[2] * a3 * at.dn);
    return turn(Vec<S>{0, 0, 1}, azimuth) * turn(Vec<S>{0, 1, 0}, polar);
  }

  // psi' = L (I1 w1^2 + I2 w2^2) / (I1^2 w1^2 + I2^2 w2^2) = L / I3 + L (I3 - I1) / (I1 I3) / (1 - n sn^2); with
  // Pi = F + (n/3) sin^3 R_J and F = u the first kind drops out:
  //   psi = L t / I1 + L (I3 - I1)(I2 - I1) / (3 I1^2 (I2 - I3) lambda) [third_kind]
  Rotation<S> at(S t) const {
    const Jacobi<S> now = lambda == 0 ? start : jacobi(lambda * t + u0, kc);
    const S side = now.halves != 2 * floor(now.halves / 2) ? -1 : 1;
    S psi = L * t / I[0];
    if (I[1] != I[0])
      psi +=
          L * (I[2] - I[0]) * (I[1] - I[0]) / (3 * I[0] * I[0] * (I[1] - I[2]) * lambda) * (third_kind(now) - third0);
    const Quat<S> q_WP = turn(axis_W, psi) * start_WP * conjugate(to_momentum(now));
    return {q_WP * conjugate(q_BP), rotate(q_BP, Vec<S>{side * a1 * now.cn, side * a2 * now.sn, a3 * now.dn})};
  }
};

// Amplitudes from the invariants, none of whose differences cancels (D, 2T: as products of moments' differences):
//   X = L^2 - 2 T I3 = I1 (I1 - I3) w1^2 + I2 (I2 - I3) w2^2,  Y = L^2 - 2 T I1 = I2 (I2 - I1) w2^2 + I3 (I3 - I1) w3^2
//   a1^2 = X / (I1 (I1 - I3)), a2^2 = X / (I2 (I2 - I3)), a3^2 = Y / (I3 (I3 - I1))
//   lambda^2 = (I3 - I2) Y / (I1 I2 I3),  kc^2 = (I3 - I1) (I3 (I3 - I2) w3^2 - I1 (I2 - I1) w1^2) / ((I3 - I2) Y)
template <class S> Top<S> make_top(Quat<S> q_BP, std::array<S, 3> I, Vec<S> w, const Quat<S>& q0_WB) {
  Top<S> top;
  // I1 < I2 < I3 here. If L circles axis 1 instead, turn by 90 degrees about axis 2: (1, 2, 3) -> (-3, 2, 1).
  if (I[2] * (I[2] - I[1]) * w[2] * w[2] < I[0] * (I[1] - I[0]) * w[0] * w[0]) {
    q_BP = q_BP * turn(Vec<S>{0, 1, 0}, pi<S>() / 2);
    w = {-w[2], w[1], w[0]};
    std::swap(I[0], I[2]);
  }
  // The quarter of the start is that of cn >= 0, which on the separatrix is the only one: a half turn about axis 3.
  if (w[0] < 0) {
    q_BP = q_BP * Quat<S>{0, 0, 0, 1};
    w = {-w[0], -w[1], w[2]};
  }
  const S d31 = I[2] - I[0], d32 = I[2] - I[1], d21 = I[1] - I[0];
  const S X = -I[0] * d31 * w[0] * w[0] - I[1] * d32 * w[1] * w[1],
          Y = I[1] * d21 * w[1] * w[1] + I[2] * d31 * w[2] * w[2];
  top.q_BP = q_BP;
  top.I = I;
  top.q0_WP = q0_WB * q_BP;
  const S sign3 = w[2] < 0 ? -1 : 1;
  top.a1 = sqrt(X / (-I[0] * d31));
  top.a2 = (d31 * sign3 < 0 ? -1 : 1) * sqrt(X / (-I[1] * d32));
  top.a3 = sign3 * sqrt(Y / (I[2] * d31));
  top.lambda = sqrt(d32 * Y / (I[0] * I[1] * I[2]));
  const S kc2 = d31 * (I[2] * d32 * w[2] * w[2] - I[0] * d21 * w[0] * w[0]) / (d32 * Y);
  top.kc = kc2 > 0 ? sqrt(kc2) : S(0);
  // sn, cn and dn of the start from the spin itself, and u0 = F = sn R_F(cn^2, dn^2, 1).
  const S sn = w[1] / top.a2, cn = w[0] / top.a1, length = sqrt(sn * sn + cn * cn);
  top.start.sn = sn / length;
  top.start.cn = cn / length;
  top.start.dn = sqrt(top.start.cn * top.start.cn + top.kc * top.kc * top.start.sn * top.start.sn);
  top.u0 = top.start.sn * carlson_rf(top.start.cn * top.start.cn, top.start.dn * top.start.dn, S(1));
  const Vec<S> momentum_P{I[0] * w[0], I[1] * w[1], I[2] * w[2]};
  top.L = norm(momentum_P);
  top.axis_W = (1 / top.L) * rotate(top.q0_WP, momentum_P);
  top.third0 = top.third_kind(top.start);
  top.start_WP = top.q0_WP * top.to_momentum(top.start);
  return top;
}

// Is w x (I w) = 0? Of a diagonal matrix exactly, from the scene's own numbers; else to the round-off of its axes.
template <class S> bool keeps_its_axis(const Body& body, const std::array<S, 3>& moment, const Vec<S>& w_P) {
  const Real33& m = body.inertia_kg_m2;
  const Real3& w = body.angular_velocity_body_rad_per_s;
  const bool diagonal = m[1] == 0 && m[2] == 0 && m[3] == 0 && m[5] == 0 && m[6] == 0 && m[7] == 0;
  // Round-off across the middle axis grows; such a motion is computed as a general top and not as a steady spin.
  const bool middle = magnitude(w_P[1]) > magnitude(w_P[0]) && magnitude(w_P[1]) > magnitude(w_P[2]);
  if (!diagonal && middle && moment[0] != moment[1] && moment[1] != moment[2]) return w_P[0] == 0 && w_P[2] == 0;
  const S least = 4 * unit_round_off<S>() * moment[2] * dot(w_P, w_P);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (diagonal && m[4 * i] != m[4 * j] && w[i] != 0 && w[j] != 0) return false;
    if (!diagonal && magnitude((moment[i] - moment[j]) * w_P[i] * w_P[j]) > least) return false;
  }
  return true;
}

}  // namespace

template <class S> RotationSolution<S> free_rotation(const Body& body, S angular_drag_N_m_s) {
  const Pose<S> start = initial_pose<S>(body);
  if (!rotates(body) || is_zero(start.w_WB_B)) return {"", steady(start.q_WB, start.w_WB_B)};
  PrincipalAxes<S> axes = principal_axes<S>(body.inertia_kg_m2);
  const std::array<S, 3>& I = axes.moment;
  const Vec<S> w = rotate(conjugate(axes.q_BP), start.w_WB_B);
  const bool straight = keeps_its_axis(body, I, w);
  if (angular_drag_N_m_s != 0) {
    // I w' = -c w along a principal axis: w = w0 exp(-c t / I), turned by (w0 I / c) (1 - exp(-c t / I)).
    if (!straight) return {"`" + body.name + "` has angular drag and does not spin about a principal axis", {}};
    const S rate = norm(w), moment = (I[0] * w[0] * w[0] + I[1] * w[1] * w[1] + I[2] * w[2] * w[2]) / (rate * rate);
    const S decay = angular_drag_N_m_s / moment;
    const Vec<S> w0 = start.w_WB_B;
    return {"", [=](S t) {
              const S angle = -rate * expm1(-decay * t) / decay;
              return Rotation<S>{start.q_WB * turn((1 / rate) * w0, angle), exp(-decay * t) * w0};
            }};
  }
  if (straight) return {"", steady(start.q_WB, start.w_WB_B)};
  const Top<S> top = make_top(axes.q_BP, I, w, start.q_WB);
  return {"", [=](S t) { return top.at(t); }};
}

template <class S>
RotationAt<S> torque_free(const std::array<S, 9>& inertia, const Quat<S>& q_WB, const Vec<S>& w_WB_B) {
  if (is_zero(w_WB_B)) return steady(q_WB, w_WB_B);
  const PrincipalAxes<S> axes = principal_axes_of<S>(inertia);
  const Vec<S> w = rotate(conjugate(axes.q_BP), w_WB_B);
  bool straight = true;  // see keeps_its_axis()
  const bool middle = magnitude(w[1]) > magnitude(w[0]) && magnitude(w[1]) > magnitude(w[2]);
  const S least = middle ? S(0) : 4 * unit_round_off<S>() * axes.moment[2] * dot(w, w);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (magnitude((axes.moment[i] - axes.moment[j]) * w[i] * w[j]) > least) straight = false;
  }
  if (straight) return steady(q_WB, w_WB_B);
  const Top<S> top = make_top(axes.q_BP, axes.moment, w, q_WB);
  return [=](S t) { return top.at(t); };
}

template RotationAt<Narrow> torque_free(const std::array<Narrow, 9>&, const Quat<Narrow>&, const Vec<Narrow>&);
template RotationAt<Wide> torque_free(const std::array<Wide, 9>&, const Quat<Wide>&, const Vec<Wide>&);
template RotationSolution<Narrow> free_rotation(const Body&, Narrow);
template RotationSolution<Wide> free_rotation(const Body&, Wide);

}  // namespace atwood::closed_form
