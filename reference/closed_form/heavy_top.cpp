// A body with an axis of symmetry on a ball joint on that axis, under uniform gravity: the heavy symmetric (Lagrange's)
// top, the spherical pendulum (no spin) and the conical one (steady precession). About the pivot the moments of inertia
// are I1 across and I3 along the axis e, which points from the pivot to the centre of mass. With z = e . up,
//   a = I3 w3 / I1,  b = L . up / I1,  beta = 2 m g l / I1,
//   z'^2 = f(z) = (1 - z^2)(|w_across|^2 + beta (z0 - z)) - (b - a z)^2 = beta (z - z1)(z2 - z)(z3 - z),
//   z = z1 + (z2 - z1) sn^2(u),  u = lambda t + u0,  lambda^2 = beta (z3 - z1) / 4,  k^2 = (z2 - z1) / (z3 - z1)
// (E. T. Whittaker, Analytical Dynamics, 4th ed. (1937), section 71). The orientation Rz(phi) Ry(theta) Rz(psi) has the
// Cayley-Klein parameters cos(theta/2) exp i(phi + psi)/2 and sin(theta/2) exp i(phi - psi)/2 with
//   (phi + psi)' = w3 - a + (b + a)/(1 + z),   (phi - psi)' = a - w3 + (b - a)/(1 - z):
// elliptic integrals of the third kind, whose parameters make them singular as the axis passes the vertical. Carlson's
// relation between R_J of two parameters (DLMF 19.21.12) turns each into an arc tangent, which combines with the
// modulus into an analytic function, and a regular integral; with D = z3 - z1, w_i = 1 + z_i:
//   cos(theta/2) exp i(phi + psi)/2 = E (sqrt(w1) cn dn +- i sqrt(w2 w3 / D) sn) / sqrt(2 q) exp i chi,
//   q = 1 + (w1 / D) sn^2,   chi' = (w3_spin - a)/2 + (b + a)/(2 D) sn^2 / q
// and the same for the other with 1 - z_i in place of 1 + z_i.
#include <optional>

#include "closed_form/complex.hpp"
#include "closed_form/elliptic.hpp"
#include "closed_form/mechanism.hpp"

namespace atwood::closed_form {

namespace {

// A rotation that takes z to the unit vector e; none for e = z.
template <class S> Quat<S> from_z(const Vec<S>& e) {
  const S half = e[2] >= 0 ? sqrt((1 + e[2]) / 2) : sqrt((1 - e[2]) / 2);
  if (e[2] >= 0) return {half, -e[1] / (2 * half), e[0] / (2 * half), 0};
  // A half turn about x takes z to -z, and e to (e0, -e1, -e2), which is on the side of z.
  return Quat<S>{0, 1, 0, 0} * Quat<S>{half, e[1] / (2 * half), e[0] / (2 * half), 0};
}

// Root of c0 + c1 x + c2 x^2 + c3 x^3 by Newton's method from `x`, from which it converges monotonically; to a double
// root by halves. None after 400 iterations.
template <class S> std::optional<S> outer_root(S c0, S c1, S c2, S c3, S x) {
  S before = 0;
  for (int k = 0; k < 400; ++k) {
    const S value = c0 + x * (c1 + x * (c2 + x * c3)), slope = c1 + x * (2 * c2 + 3 * x * c3);
    if (value == 0 || slope == 0) return x;
    const S step = -value / slope;
    if (k > 0 && (step * before <= 0 || magnitude(step) <= unit_round_off<S>() * magnitude(x))) return x;
    x += step;
    before = step;
  }
  return std::nullopt;
}

// Roots lower <= 0 <= upper with the given sum and product <= 0, neither with cancellation.
template <class S> void opposite_roots(S sum, S product, S& lower, S& upper) {
  const S root = sqrt(sum * sum - 4 * product);
  if (sum >= 0) {
    upper = (sum + root) / 2;
    lower = upper == 0 ? S(0) : product / upper;
  } else {
    lower = (sum - root) / 2;
    upper = product / lower;
  }
}

// The start: its quantities without cancellation where the axis is close to the vertical.
template <class S> struct Start {
  S above{}, below{};                                    // 1 + z0, 1 - z0
  S z{}, dz{}, across2{}, a{}, minus{}, plus{}, beta{};  // minus: b - a, plus: b + a
  S lift{};                                              // up . w_across = b - a z0
};

// f'(z0), which is 2 z''.
template <class S> S slope_at_start(const Start<S>& s) {
  return -2 * s.z * s.across2 - s.beta * s.above * s.below + 2 * s.a * s.lift;
}

// Distances of the roots from each other, from the start, from the top and from the bottom.
template <class S> struct Roots {
  S y1{}, y2{};                    // z1 - z0 <= 0 <= z2 - z0
  S span{}, gap{}, whole{};        // z2 - z1, z3 - z2, z3 - z1
  S above1{}, above2{}, above3{};  // 1 + z_i
  S below1{}, below2{}, beyond{};  // 1 - z1, 1 - z2, z3 - 1
};

// f about z0: f0 + f1 y + f2 y^2 + beta y^3; about 1: -(b - a)^2 + t1 x + t2 x^2 + beta x^3. Either z3 or z1 lies apart
// from the other two, which follow from it by a quadratic equation with roots of opposite signs. None: the iteration
// for z1 or z3 did not converge.
template <class S> std::optional<Roots<S>> find_roots(const Start<S>& s) {
  const S f0 = s.dz * s.dz, f1 = slope_at_start(s), f2 = -s.across2 + 2 * s.beta * s.z - s.a * s.a;
  const S t0 = -s.minus * s.minus, t1 = -2 * s.across2 + 2 * s.beta * s.below + 2 * s.a * s.minus,
          t2 = f2 + 3 * s.beta * s.below;
  const S far = 1 + larger(magnitude(t0), larger(magnitude(t1), magnitude(t2))) / s.beta;
  const std::optional<S> highest = outer_root(t0, t1, t2, s.beta, far);
  const std::optional<S> lowest = outer_root(t0, t1, t2, s.beta, S(-2));
  if (!highest || !lowest) return std::nullopt;
  S x3 = larger(S(0), *highest), x1 = *lowest, x2;
  const S middle = -t2 / s.beta - x1 - x3;
  Roots<S> r;
  S y3;
  if (x3 - middle >= middle - x1) {
    y3 = x3 + s.below;
    const S product = -f0 / (s.beta * y3);
    opposite_roots((f1 / s.beta - product) / y3, product, r.y1, r.y2);
    x1 = r.y1 - s.below;
    x2 = r.y2 - s.below;
    if (magnitude(x2) < s.below / 2 && x3 > 0 && x1 < 0) x2 = s.minus * s.minus / (s.beta * x1 * x3);
    r.gap = y3 - r.y2;
  } else {
    const S product = s.minus * s.minus / (s.beta * x1);
    opposite_roots((t1 / s.beta - product) / x1, product, x2, x3);
    y3 = x3 + s.below;
    r.y1 = x1 + s.below;
    r.y2 = x2 + s.below;
    if (y3 > 0 && magnitude(r.y2) < magnitude(r.y1)) r.y2 = -f0 / (s.beta * y3 * r.y1);
    else if (y3 > 0 && r.y2 != 0) r.y1 = -f0 / (s.beta * y3 * r.y2);
    r.gap = x3 - x2;
  }
  if (r.y1 > 0) r.y1 = 0;
  if (r.y2 < 0) r.y2 = 0;
  r.span = r.y2 - r.y1;
  r.whole = r.gap + r.span;
  r.above2 = s.above + r.y2;
  r.above3 = s.above + y3;
  r.above1 = -r.y1 < s.above / 2 ? s.above + r.y1 : s.plus * s.plus / (s.beta * r.above2 * r.above3);
  if (r.above2 == 0) r.above1 = 0;
  r.below1 = -x1;
  r.below2 = larger(S(0), -x2);
  r.beyond = x3;
  return r;
}

// One of the two Cayley-Klein parameters without its constant phase, and its derivative.
template <class S> struct Parameter { Complex<S> value, rate; };

template <class S> struct Top {
  Start<S> start;
  Roots<S> r;
  S lambda{}, kc{}, u0{}, spin{};  // spin: w3
  bool is_steady = false;
  Jacobi<S> at0;
  Complex<S> first_phase{1, 0}, second_phase{1, 0};
  Quat<S> q_WU{1, 0, 0, 0}, q_BP{1, 0, 0, 0}, q_FW{1, 0, 0, 0};  // q_FW: world to the joint's frame of the parent
  S I1{}, I3{}, moment{};                                        // moment: m g l

  // False: the roots were not found.
  bool set_motion() {
    const std::optional<Roots<S>> found = find_roots(start);
    if (!found) return false;
    r = *found;
    lambda = sqrt(start.beta * r.whole) / 2;
    kc = sqrt(r.gap / r.whole);
    if (r.span > 0) {
      at0.sn = (start.dz < 0 ? -1 : 1) * sqrt(-r.y1 / r.span);
      at0.cn = sqrt(r.y2 / r.span);
    }
    at0.dn = sqrt((r.gap + r.span * at0.cn * at0.cn) / r.whole);
    u0 = at0.sn * carlson_rf(at0.cn * at0.cn, at0.dn * at0.dn, S(1));
    return true;
  }

  // sn^3 R_J(cn^2, dn^2, 1, q), continued over half periods; q = head + tail cn^2.
  S third_kind(const Jacobi<S>& at, S head, S tail) const {
    const S q = head + tail * at.cn * at.cn;
    const S part = at.sn == 0 ? S(0) : at.sn * at.sn * at.sn * carlson_rj(at.cn * at.cn, at.dn * at.dn, S(1), q);
    return at.halves == 0 ? part : part + 2 * at.halves * carlson_rj(S(0), kc * kc, S(1), head);
  }

  // (real cn dn + i imaginary sn) / sqrt(2 q) exp(i chi), q = head + tail cn^2 and chi' = steady + slope sn^2 / q.
  Parameter<S> analytic(const Jacobi<S>& at, S t, S real, S imaginary, S head, S tail, S steady, S slope) const {
    const S q = head + tail * at.cn * at.cn, root = sqrt(2 * q), dq = -2 * lambda * tail * at.sn * at.cn * at.dn;
    const S k2 = r.span / r.whole, side = at.halves != 2 * floor(at.halves / 2) ? -1 : 1;
    S chi = steady * t;
    if (slope != 0) chi += slope / (3 * lambda) * (third_kind(at, head, tail) - third_kind(at0, head, tail));
    const Complex<S> form{side * real * at.cn * at.dn / root, side * imaginary * at.sn / root};
    const Complex<S> change{-side * lambda * real * at.sn * (at.dn * at.dn + k2 * at.cn * at.cn) / root,
                            side * lambda * imaginary * at.cn * at.dn / root};
    const Complex<S> turned{cos(chi), sin(chi)};
    const Complex<S> logarithmic{-dq / (2 * q), steady + slope * at.sn * at.sn / q};
    return {form * turned, (change + form * logarithmic) * turned};
  }

  Parameter<S> first(const Jacobi<S>& at, S t) const {
    const S side = start.plus < 0 ? -1 : 1;
    return analytic(at, t, sqrt(r.above1), side * sqrt(r.above2 * r.above3 / r.whole), 1 + r.above1 / r.whole,
                    -r.above1 / r.whole, (spin - start.a) / 2, start.plus / (2 * r.whole));
  }
  Parameter<S> second(const Jacobi<S>& at, S t) const {
    const S steady = (start.a - spin) / 2, side = start.minus < 0 ? -1 : 1;
    if (r.below2 <= r.beyond)
      return analytic(at, t, sqrt(r.below1), side * sqrt(r.below2 * r.beyond / r.whole), r.beyond / r.whole,
                      r.below1 / r.whole, steady, -start.minus / (2 * r.whole));
    // The axis stays away from the vertical: modulus and phase, 1 - z = below1 (1 - n sn^2).
    const S below = r.below2 + r.span * at.cn * at.cn, n = r.span / r.below1;
    const S dz = 2 * r.span * lambda * at.sn * at.cn * at.dn;
    const S head = r.below2 / r.below1;
    S phase = steady * t;
    if (start.minus != 0)
      phase +=
          start.minus / (2 * r.below1) * (t + n / (3 * lambda) * (third_kind(at, head, n) - third_kind(at0, head, n)));
    const Complex<S> value = scaled(sqrt(below / 2), Complex<S>{cos(phase), sin(phase)});
    return {value, value * Complex<S>{-dz / (2 * below), steady + start.minus / (2 * below)}};
  }

  // z' = z'' = 0: the phases are linear in time.
  static Parameter<S> steady_turn(S t, S square, S rate) {
    const Complex<S> value = scaled(sqrt(square / 2), Complex<S>{cos(rate * t), sin(rate * t)});
    return {value, value * Complex<S>{0, rate}};
  }
  Parameter<S> first_at(S t, const Jacobi<S>& now) const {
    if (!is_steady) return first(now, t);
    return steady_turn(t, start.above, (spin - start.a + (start.above > 0 ? start.plus / start.above : S(0))) / 2);
  }
  Parameter<S> second_at(S t, const Jacobi<S>& now) const {
    if (!is_steady) return second(now, t);
    return steady_turn(t, start.below, (start.a - spin + (start.below > 0 ? start.minus / start.below : S(0))) / 2);
  }

  JointState<S> at(S t) const {
    const Jacobi<S> now = is_steady ? Jacobi<S>{} : jacobi(lambda * t + u0, kc);
    const Parameter<S> one = first_at(t, now), two = second_at(t, now);
    const Complex<S> a = first_phase * one.value, da = first_phase * one.rate, b = second_phase * two.value,
                     db = second_phase * two.rate;
    Quat<S> q{a.re, -b.im, b.re, a.im};
    const Quat<S> dq{da.re, -db.im, db.re, da.im};
    const Quat<S> half = conjugate(q) * dq;
    const S length2 = square_of(a) + square_of(b);
    const Vec<S> w{2 * half[1] / length2, 2 * half[2] / length2, spin};
    for (S& part : q) part /= sqrt(length2);
    // I1 w1' = (I1 - I3) w2 w3 + M1: Euler's equations with the moment l z x m g, g = -up in the body.
    const Vec<S> up = rotate(conjugate(q), Vec<S>{0, 0, 1});
    const Vec<S> dw{((I1 - I3) * w[1] * spin + moment * up[1]) / I1, ((I3 - I1) * w[0] * spin - moment * up[0]) / I1,
                    0};
    JointState<S> made;
    made.q = q_FW * q_WU * q * conjugate(q_BP);
    made.u = rotate(q_BP, w);
    made.du = rotate(q_BP, dw);
    return made;
  }
};

// The constant phase that takes (g, g') to (value, rate): least squares, since either may vanish.
template <class S>
Complex<S> phase_between(const Parameter<S>& g, const Complex<S>& value, const Complex<S>& rate, S lambda) {
  const Complex<S> sum = value * conjugate(g.value) + scaled(1 / (lambda * lambda), rate * conjugate(g.rate));
  const S length = sqrt(square_of(sum));
  return length == 0 ? Complex<S>{1, 0} : scaled(1 / length, sum);
}

// Moments about the centre across and along e; empty unless the body is symmetric about e to round-off.
template <class S> std::string symmetric_about(const Body& body, const Vec<S>& e, S& across, S& along) {
  const auto& I = body.inertia_kg_m2;
  Vec<S> Ie{};
  S trace = 0, off = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    trace += S(I[4 * i]);
    for (std::size_t j = 0; j < 3; ++j) Ie[i] += S(I[3 * i + j]) * e[j];
  }
  along = dot(e, Ie);
  across = (trace - along) / 2;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      off = larger(off, magnitude(S(I[3 * i + j]) - (i == j ? across : S(0)) - (along - across) * e[i] * e[j]));
  if (off > 32 * unit_round_off<S>() * trace)
    return "`" + body.name + "` is not symmetric about the line from its ball joint to its centre of mass";
  return "";
}

template <class S> std::string build(const Scene& scene, std::size_t index, Top<S>& top) {
  const Joint& joint = scene.joints[index];
  if (!is_grounded(scene, joint)) return "the joint `" + joint.name + "` does not join its body to the world";
  const Body& body = scene.bodies[static_cast<std::size_t>(joint.child)];
  const Vec<S> arm = S(-1) * vec<S>(joint.anchors_body_m[1]), g = vec<S>(scene.gravity_m_per_s2);
  const S l = norm(arm), weight = S(body.mass_kg) * norm(g);
  if (!(l * weight > 0)) return "gravity has no moment about the joint `" + joint.name + "`";
  const Vec<S> e_B = (1 / l) * arm, up = (-1 / norm(g)) * g;
  if (std::string why = symmetric_about(body, e_B, top.I1, top.I3); !why.empty()) return why;
  top.I1 += S(body.mass_kg) * l * l;
  top.moment = weight * l;
  top.q_WU = from_z(up);
  top.q_BP = from_z(e_B);
  const JointState<S> state = initial_joint<S>(joint);
  Quat<S> q_WF = quat<S>(joint.frame_wxyz);
  if (joint.parent >= 0) q_WF = quat<S>(scene.bodies[static_cast<std::size_t>(joint.parent)].orientation_wxyz) * q_WF;
  top.q_FW = conjugate(q_WF);
  const Quat<S> q = conjugate(top.q_WU) * q_WF * Quat<S>(state.q) * top.q_BP;  // P axes to U axes
  const Vec<S> w = rotate(conjugate(top.q_BP), state.u), e = rotate(q, Vec<S>{0, 0, 1});
  const Vec<S> up_P = rotate(conjugate(q), Vec<S>{0, 0, 1});
  Start<S>& s = top.start;
  top.spin = w[2];
  s.beta = 2 * top.moment / top.I1;
  s.a = top.I3 * top.spin / top.I1;
  s.z = e[2];
  const S side2 = e[0] * e[0] + e[1] * e[1];  // 1 - z^2
  s.above = s.z > 0 ? 1 + s.z : side2 / (1 - s.z);
  s.below = s.z > 0 ? side2 / (1 + s.z) : 1 - s.z;
  s.across2 = w[0] * w[0] + w[1] * w[1];
  s.lift = up_P[0] * w[0] + up_P[1] * w[1];
  s.dz = up_P[0] * w[1] - up_P[1] * w[0];
  s.plus = s.lift + s.a * s.above;  // b = lift + a z
  s.minus = s.lift - s.a * s.below;
  top.lambda = sqrt(s.beta);
  top.is_steady = s.dz == 0 && slope_at_start(s) == 0;
  const Quat<S> rate = q * Quat<S>{0, w[0] / 2, w[1] / 2, w[2] / 2};
  if (!top.is_steady && !top.set_motion())
    return "the roots between which the top of `" + joint.name +
           "` nutates were not found: their iteration did not converge";
  top.first_phase =
      phase_between(top.first_at(S(0), top.at0), Complex<S>{q[0], q[3]}, Complex<S>{rate[0], rate[3]}, top.lambda);
  top.second_phase =
      phase_between(top.second_at(S(0), top.at0), Complex<S>{q[2], -q[1]}, Complex<S>{rate[2], -rate[1]}, top.lambda);
  return "";
}

template <class S> Motion<S> solve_heavy_top(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> refused;
  refused.refusal = not_a_tree(scene);
  if (refused.refusal.empty() && scene.joints.empty()) refused.refusal = "expected a ball joint; found none";
  std::vector<Top<S>> all(scene.joints.size());
  for (std::size_t j = 0; j < all.size() && refused.refusal.empty(); ++j) refused.refusal = build(scene, j, all[j]);
  if (!refused.refusal.empty()) return refused;
  return move_mechanism<S>(scenario, t_s, [&](S t) {
    std::vector<JointState<S>> joints;
    for (const Top<S>& each : all) joints.push_back(each.at(t));
    return joints;
  });
}

}  // namespace

Solution heavy_top() {
  return {
      "heavy-top",
      "heavy symmetric top and spherical pendulum, Whittaker, Analytical Dynamics, section 71 (Jacobi's functions and "
      "elliptic integrals of the third kind)",
      feature::uniform_gravity | feature::spin | feature::ball_joint, solve_heavy_top<Narrow>, solve_heavy_top<Wide>};
}

}  // namespace atwood::closed_form
