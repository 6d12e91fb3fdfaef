#include "joints/tree_rates.hpp"

#include <algorithm>

#include "math/sin_cos.hpp"

namespace atwood {
namespace {

// ---- vectors, matrices and quaternions whose components are scalars or packs -------------------------------------
#define ATWOOD_MIXED template <class A, class B> ATWOOD_INLINE auto
ATWOOD_MIXED product(const Mat3<A>& a, const Vec3<B>& v) {
  return Vec3<decltype(a.x.x * v.x)>{dot(a.x, v), dot(a.y, v), dot(a.z, v)};
}
ATWOOD_MIXED product(const Sym3<A>& a, const Vec3<B>& v) {
  return Vec3<decltype(a.xx * v.x)>{a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z,
                                    a.xz * v.x + a.yz * v.y + a.zz * v.z};
}
ATWOOD_MIXED product(const Quat<A>& a, const Quat<B>& b) {
  return Quat<decltype(a.w * b.w)>{
      a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
      a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
#undef ATWOOD_MIXED

// a^T v
template <class V> ATWOOD_INLINE Vec3<V> transposed_product(const Mat3<V>& a, const Vec3<V>& v) {
  return {a.x.x * v.x + a.y.x * v.y + a.z.x * v.z, a.x.y * v.x + a.y.y * v.y + a.z.y * v.z,
          a.x.z * v.x + a.y.z * v.y + a.z.z * v.z};
}
// to - a b^T
template <class V> ATWOOD_INLINE void subtract_outer(Sym3<V>& to, const Vec3<V>& a, const Vec3<V>& b) {
  to = {to.xx - a.x * b.x, to.xy - a.x * b.y, to.xz - a.x * b.z,
        to.yy - a.y * b.y, to.yz - a.y * b.z, to.zz - a.z * b.z};
}
template <class V> ATWOOD_INLINE void subtract_outer(Mat3<V>& to, const Vec3<V>& a, const Vec3<V>& b) {
  to = {to.x - a.x * b, to.y - a.y * b, to.z - a.z * b};
}
template <class V> ATWOOD_INLINE Sym3<V> sum(const Sym3<V>& a, const Sym3<V>& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
}
template <class V> ATWOOD_INLINE Mat3<V> sum(const Mat3<V>& a, const Mat3<V>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

template <class V, class S> ATWOOD_INLINE Quat<V> all(const Quat<S>& q) {
  return {in_all_lanes<V>(q.w), in_all_lanes<V>(q.x), in_all_lanes<V>(q.y), in_all_lanes<V>(q.z)};
}
template <class V, class S> ATWOOD_INLINE Vec3<V> all(const Vec3<S>& v) {
  return {in_all_lanes<V>(v.x), in_all_lanes<V>(v.y), in_all_lanes<V>(v.z)};
}
template <class S, class V> ATWOOD_INLINE Vec3<V> zero3() { return all<V>(Vec3<S>{}); }

// The rotation of a unit quaternion.
template <class S, class V> ATWOOD_INLINE Mat3<V> rotation(const Quat<V>& q) {
  const V x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const V wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  const V xx = q.x * x2, xy = q.x * y2, xz = q.x * z2, yy = q.y * y2, yz = q.y * z2, zz = q.z * z2;
  return {
      {S(1) - (yy + zz), xy - wz, xz + wy}, {xy + wz, S(1) - (xx + zz), yz - wx}, {xz - wy, yz + wx, S(1) - (xx + yy)}};
}
// frame exp(axis angle), with frame_axis = frame (0, axis).
template <class S, class V> ATWOOD_INLINE Quat<V> turned_frame(const Link<S>& link, const V& angle) {
  V sine, cosine;
  real::same_sin_cos(S(0.5) * angle, sine, cosine);
  const Quat<S>&f = link.frame, &g = link.frame_axis;
  return {cosine * f.w + sine * g.w, cosine * f.x + sine * g.x, cosine * f.y + sine * g.y, cosine * f.z + sine * g.z};
}
template <class V> ATWOOD_INLINE Vec3<V> column_of(const Mat3<V>& a, int k) {
  return k == 0 ? Vec3<V>{a.x.x, a.y.x, a.z.x} : k == 1 ? Vec3<V>{a.x.y, a.y.y, a.z.y} : Vec3<V>{a.x.z, a.y.z, a.z.z};
}
// [alpha] + [w][w]
template <class V> ATWOOD_INLINE Mat3<V> turning(const Vec3<V>& alpha, const Vec3<V>& w) {
  const V xx = w.x * w.x, yy = w.y * w.y, zz = w.z * w.z, xy = w.x * w.y, xz = w.x * w.z, yz = w.y * w.z;
  return {{-(yy + zz), xy - alpha.z, xz + alpha.y},
          {xy + alpha.z, -(xx + zz), yz - alpha.x},
          {xz - alpha.y, yz + alpha.x, -(xx + yy)}};
}
// R J R^T
template <class S, class V> ATWOOD_INLINE Sym3<V> in_world(const Mat3<V>& R, const Sym3<S>& J, bool diagonal) {
  const auto entries = [&](const Vec3<V>& x, const Vec3<V>& y, const Vec3<V>& z) ATWOOD_INLINED {
    return Sym3<V>{dot(R.x, x), dot(R.x, y), dot(R.x, z), dot(R.y, y), dot(R.y, z), dot(R.z, z)};
  };
  const auto scaled = [&](const Vec3<V>& row) ATWOOD_INLINED {
    return Vec3<V>{J.xx * row.x, J.yy * row.y, J.zz * row.z};
  };
  if (diagonal) return entries(scaled(R.x), scaled(R.y), scaled(R.z));
  return entries(product(J, R.x), product(J, R.y), product(J, R.z));
}

bool rate_turns(JointKind kind, int k) {
  return kind == JointKind::slider ? false : kind == JointKind::cylindrical ? k == 0 : true;
}

}  // namespace

template <class S> TreeRates<S>::TreeRates(const Tree<S>& tree) : freedoms_(tree.rate_count()) {
  const int count = static_cast<int>(tree.links().size());
  nodes_.resize(count);
  if constexpr (PackOf<S>::in_register) {
    node_lanes_.resize(nodes_.size());
    freedom_lanes_.resize(freedoms_.size());
  }
  for (int i = 0; i < count; ++i) {
    const Link<S>& link = tree.links()[i];
    const Sym3<S>& J = link.J_B;
    links_.push_back({&link, J.xy == S(0) && J.xz == S(0) && J.yz == S(0), link.parent, tree.root_attitude(i)});
  }
}

// d is the way from the parent's A to the link's; alpha0 and a0 are
//   hinge        alpha_p + w_p x s u                         a_p + B_p d
//   slider       alpha_p                                     a_p + B_p d + 2 w_p x s u
//   cylindrical  alpha_p + w_p x s u0                        a_p + B_p d + 2 w_p x s u1
//   universal    alpha_p + w_p x s1 u0 + w x s2 u1           a_p + B_p d
//   ball         alpha_p + w_p x R w_rel                     a_p + B_p d
template <class S>
template <class States, class V>
ATWOOD_INLINE void TreeRates<S>::outward_pass(const Constants& of, const States& y, const Node<V>& parent, Node<V>& m,
                                              Freedom<V>* freedom) const {
  const Link<S>& link = *of.link;
  const V none = in_all_lanes<V>(S(0));
  const auto at3 = [&](int i) ATWOOD_INLINED { return Vec3<V>{y.at(i), y.at(i + 1), y.at(i + 2)}; };
  const auto at4 = [&](int i) ATWOOD_INLINED { return Quat<V>{y.at(i), y.at(i + 1), y.at(i + 2), y.at(i + 3)}; };
  const auto set_turning = [&](int i, const Quat<V>& q, const Vec3<V>& w) ATWOOD_INLINED {
    const Quat<V> rate = quaternion_rate(q, w, S(0.5));
    y.set(i, rate.w);
    y.set(i + 1, rate.x);
    y.set(i + 2, rate.y);
    y.set(i + 3, rate.z);
  };
  if (link.joint < 0) {  // free: its point A is its centre of mass
    for (int k = 0; k < 3; ++k) y.set(link.at_q + k, y.at(link.at_q + 3 + k));
    for (int k = 0; k < 3; ++k) freedom[k].s = all<V>(Vec3<S>{S(k == 0), S(k == 1), S(k == 2)});
    m.q = all<V>(Quat<S>{});
    m.w = zero3<S, V>();
    if (link.rotates) {
      m.q = at4(link.at_q + 6);
      const Vec3<V> w = at3(link.at_q + 10);
      set_turning(link.at_q + 6, m.q, w);
      m.R = rotation<S>(m.q);
      m.w = product(m.R, w);
      for (int k = 3; k < 6; ++k) freedom[k].s = column_of(m.R, k - 3);
    } else {
      m.R = rotation<S>(m.q);
    }
    m.d = zero3<S, V>();
    m.alpha = zero3<S, V>();
    m.a = parent.a;
    m.B = turning(m.alpha, m.w);
    return;
  }
  V q[2] = {none, none}, u[2] = {none, none};
  if (link.kind != JointKind::ball)
    for (int k = 0; k < link.rates; ++k) {
      q[k] = link.driven ? link.driven_start + y.time() * link.driven_rate : y.at(link.at_q + k);
      u[k] = link.driven ? in_all_lanes<V>(link.driven_rate) : y.at(link.at_u + k);
      y.set(link.at_q + k, u[k]);
    }
  Vec3<V> d = product(parent.R, link.from_parent_P), w = parent.w, alpha = parent.alpha;
  Vec3<V> sliding = zero3<S, V>();
  if (link.kind == JointKind::hinge || link.kind == JointKind::cylindrical) {
    m.q = product(parent.q, turned_frame(link, q[0]));
  } else if (link.kind == JointKind::universal) {
    V sine, cosine;
    real::same_sin_cos(S(0.5) * q[0], sine, cosine);
    const Vec3<S>& axis = link.axis_P;
    m.q = product(parent.q,
                  product(Quat<V>{cosine, sine * axis.x, sine * axis.y, sine * axis.z}, turned_frame(link, q[1])));
  } else if (link.kind == JointKind::ball) {
    const Quat<V> q_joint = at4(link.at_q);
    m.q = product(parent.q, product(link.frame, q_joint));
  } else {
    m.q = product(parent.q, link.frame);
  }
  m.R = rotation<S>(m.q);
  const auto turn_about = [&](int k, const Vec3<V>& s, const Vec3<V>& carrier_w) ATWOOD_INLINED {
    freedom[k].s = s;
    w = w + u[k] * s;
    alpha = alpha + u[k] * cross(carrier_w, s);
  };
  switch (link.kind) {
    case JointKind::fixed: break;
    case JointKind::hinge: turn_about(0, product(m.R, link.axis_B), parent.w); break;
    case JointKind::slider:
    case JointKind::cylindrical: {
      const int along = link.kind == JointKind::slider ? 0 : 1;
      const Vec3<V> s = product(m.R, link.axis_B);
      freedom[along].s = s;
      d = d + q[along] * s;
      sliding = u[along] * s;
      if (along == 1) turn_about(0, s, parent.w);
      break;
    }
    case JointKind::universal:
      turn_about(0, product(parent.R, link.axis_P), parent.w);
      turn_about(1, product(m.R, link.axis_B), w + u[1] * product(m.R, link.axis_B));
      break;
    case JointKind::ball: {
      const Vec3<V> rate_B = at3(link.at_u), relative = product(m.R, rate_B);
      set_turning(link.at_q, at4(link.at_q), rate_B);
      for (int k = 0; k < 3; ++k) freedom[k].s = column_of(m.R, k);
      w = w + relative;
      alpha = alpha + cross(parent.w, relative);
      break;
    }
  }
  Vec3<V> a = parent.a + product(parent.B, d);
  if (link.kind == JointKind::slider || link.kind == JointKind::cylindrical) a = a + S(2) * cross(parent.w, sliding);
  m.d = d;
  m.w = w;
  m.alpha = alpha;
  m.a = a;
  m.B = turning(alpha, w);
}

// The inertia about A, and the wrench of the motion at constant rates.
template <class S> template <class V> ATWOOD_INLINE void TreeRates<S>::start(const Constants& of, Node<V>& m) const {
  const Link<S>& link = *of.link;
  const V none = in_all_lanes<V>(S(0)), mass = in_all_lanes<V>(link.mass_kg);
  const Vec3<V> r = product(m.R, link.to_centre_B), h = link.mass_kg * r;
  m.J = in_world(m.R, link.J_B, of.diagonal);
  m.H = {{none, -h.z, h.y}, {h.z, none, -h.x}, {-h.y, h.x, none}};
  m.M = {mass, none, none, mass, none, mass};
  m.f = link.mass_kg * (m.a + product(m.B, r));
  m.n = cross(m.w, product(m.J, m.w)) + product(m.J, m.alpha) + cross(h, m.a);
}

template <class S>
template <class Applied, class V>
ATWOOD_INLINE void TreeRates<S>::inward_pass(const Constants& of, const Applied& applied, Node<V>& m,
                                             Freedom<V>* freedom) const {
  const Link<S>& link = *of.link;
  if (link.driven) return;
  for (int k = 0; k < link.rates; ++k) {
    Freedom<V>& one = freedom[k];
    const Vec3<V> s = one.s;
    const bool angular = link.joint < 0 ? k >= 3 : rate_turns(link.kind, k);
    if (angular) {
      one.U_n = product(m.J, s);
      one.U_f = transposed_product(m.H, s);
      one.inverse_D = S(1) / dot(s, one.U_n);
      one.force = applied[link.first_rate + k] - dot(s, m.n);
    } else {
      one.U_n = product(m.H, s);
      one.U_f = product(m.M, s);
      one.inverse_D = S(1) / dot(s, one.U_f);
      one.force = applied[link.first_rate + k] - dot(s, m.f);
    }
    if (of.parent < 0 && k + 1 == link.rates) return;  // nothing is left to be moved
    const V share = one.force * one.inverse_D;
    const Vec3<V> U_n = one.inverse_D * one.U_n, U_f = one.inverse_D * one.U_f;
    subtract_outer(m.J, U_n, one.U_n);
    subtract_outer(m.H, U_n, one.U_f);
    subtract_outer(m.M, U_f, one.U_f);
    m.n = m.n + share * one.U_n;
    m.f = m.f + share * one.U_f;
  }
}

// As Tree::add_to_parent, without the bias of the joint's motion.
template <class S>
template <class V>
ATWOOD_INLINE void TreeRates<S>::add_to_parent(const Node<V>& m, Node<V>& to) const {
  const Vec3<V> d = m.d;
  to.n = to.n + (m.n + cross(d, m.f));
  to.f = to.f + m.f;
  const Vec3<V> Mx{m.M.xx, m.M.xy, m.M.xz}, My{m.M.xy, m.M.yy, m.M.yz}, Mz{m.M.xz, m.M.yz, m.M.zz};
  const Mat3<V> H{m.H.x + (d.y * Mz - d.z * My), m.H.y + (d.z * Mx - d.x * Mz), m.H.z + (d.x * My - d.y * Mx)};
  const Vec3<V> tx = cross(d, m.H.x), ty = cross(d, m.H.y), tz = cross(d, m.H.z);  // columns of [d] H^T
  const Vec3<V> bx = cross(d, H.x), by = cross(d, H.y), bz = cross(d, H.z);        // rows of -H' [d]
  to.M = sum(to.M, m.M);
  to.H = sum(to.H, H);
  to.J = sum(to.J, sum(m.J, Sym3<V>{tx.x + bx.x, ty.x + bx.y, tz.x + bx.z, ty.y + by.y, tz.y + by.z, tz.z + bz.z}));
}

// alpha and a, of the parent's motion, take the changes by the rates' u', which are written.
template <class S>
template <class States, class V>
ATWOOD_INLINE void TreeRates<S>::acceleration_pass(const Constants& of, const States& y, const Freedom<V>* freedom,
                                                   Vec3<V>& alpha, Vec3<V>& a) const {
  const Link<S>& link = *of.link;
  const int to = link.joint < 0 ? link.at_q + 3 : link.at_u;
  for (int k = link.rates - 1; k >= 0; --k) {
    // of a free body v stands before q, and w behind it
    const int at = link.joint < 0 && k >= 3 ? link.at_q + 7 + k : to + k;
    if (link.driven) {
      y.set(at, in_all_lanes<V>(S(0)));
      continue;
    }
    const Freedom<V>& one = freedom[k];
    const V du = (one.force - (dot(one.U_n, alpha) + dot(one.U_f, a))) * one.inverse_D;
    y.set(at, du);
    const bool angular = link.joint < 0 ? k >= 3 : rate_turns(link.kind, k);
    if (angular) alpha = alpha + du * one.s;
    else a = a + du * one.s;
  }
}

template <class S>
template <class States, class Applied, class V>
ATWOOD_INLINE void TreeRates<S>::evaluate(const States& y, const Vec3<S>& gravity_W, const Applied& applied,
                                          Node<V>* nodes, Freedom<V>* freedoms) const {
  const int count = static_cast<int>(links_.size());
  Node<V> root;
  root.w = root.alpha = root.d = zero3<S, V>();
  root.a = all<V>(S(-1) * gravity_W);
  root.B = {root.w, root.w, root.w};
  for (int i = 0; i < count; ++i) {
    const Constants& of = links_[i];
    if (of.parent < 0) {
      root.q = all<V>(of.q_root);
      root.R = rotation<S>(root.q);
    }
    outward_pass(of, y, of.parent < 0 ? root : nodes[of.parent], nodes[i], freedoms + of.link->first_rate);
  }
  // Links are started as late as their children allow: the way inwards waits for each link's result and leaves room.
  for (int i = count - 1, started = count; i >= 0; --i) {
    while (started > std::max(links_[i].parent, 0)) --started, start(links_[started], nodes[started]);
    inward_pass(links_[i], applied, nodes[i], freedoms + links_[i].link->first_rate);
    if (links_[i].parent >= 0) add_to_parent(nodes[i], nodes[links_[i].parent]);
  }
  Vec3<V> alpha = zero3<S, V>(), a = alpha;  // of the link before, which mostly is the parent
  for (int i = 0; i < count; ++i) {
    Node<V>& m = nodes[i];
    const int parent = links_[i].parent;
    if (parent < 0) {
      alpha = a = zero3<S, V>();
    } else {
      if (parent != i - 1) alpha = nodes[parent].alpha, a = nodes[parent].a;
      a = a + cross(alpha, m.d);
    }
    acceleration_pass(links_[i], y, freedoms + links_[i].link->first_rate, alpha, a);
    m.alpha = alpha;
    m.a = a;
  }
}

template <class S> void TreeRates<S>::rates(const OneState<S>& y, const Vec3<S>& gravity_W, const S* applied) {
  run_scalar<S>(widest_vectors(),
                [&]() ATWOOD_INLINED { evaluate(y, gravity_W, applied, nodes_.data(), freedoms_.data()); });
}

template <class S>
void TreeRates<S>::rates(VectorWidth width, const StateLanes<S>& y, const Vec3<S>& gravity_W,
                         const LaneBlock<S>* applied) {
  if constexpr (PackOf<S>::in_register)
    in_lanes<S>(width, [&](auto w) ATWOOD_INLINED {
      constexpr VectorWidth at = decltype(w)::value;
      evaluate(y.template at_width<at>(), gravity_W, LaneValues<PackAt<S, at>>{lanes_of(applied)},
               node_lanes_.template at<at>().data(), freedom_lanes_.template at<at>().data());
    });
}

template class TreeRates<float>;
template class TreeRates<double>;
template class TreeRates<long double>;
template class TreeRates<Quad>;

}  // namespace atwood
