// Kinematics of trees: poses, velocities and bias accelerations, from the roots outwards.
#include "math/dual.hpp"  // before templates that use it

#include "joints/tree.hpp"

namespace atwood {
namespace {

template <class S> Quat<S> pure(const Vec3<S>& v) { return {S(0), v.x, v.y, v.z}; }

// q + factor r
template <class S> Quat<S> sum(S a, const Quat<S>& q, S b, const Quat<S>& r) {
  return {a * q.w + b * r.w, a * q.x + b * r.x, a * q.y + b * r.y, a * q.z + b * r.z};
}

// frame exp(axis angle), with frame_axis = frame (0, axis).
template <class S> Quat<S> turned_frame(const Link<S>& link, S angle) {
  S sine, cosine;
  real::sin_cos(angle / S(2), sine, cosine);
  return sum(cosine, link.frame, sine, link.frame_axis);
}

}  // namespace

template <class S> void Tree<S>::kinematics(S t_s, const S* y, DrivenJoints driven) {
  for (int i = 0; i < static_cast<int>(links_.size()); ++i) move_link(t_s, y, driven, i);
}

// Accelerations of the child at constant rates, with w, A' of the parent and s fixed in the parent or the child:
//   hinge        c_n = w x s u                           c_f = w x (w x d)
//   slider       c_n = 0                                 c_f = w x (w x d) + 2 w x s u
//   cylindrical  c_n = w x s u0                          c_f = w x (w x d) + 2 w x s u1
//   universal    c_n = w x s1 u0 + w_child x s2 u1       c_f = w x (w x d)
//   ball         c_n = w_child x R w_rel = w x R w_rel   c_f = w x (w x d)
template <class S> void Tree<S>::move_link(S t_s, const S* y, DrivenJoints driven, int i) {
  const Link<S>& link = links_[i];
  LinkMotion<S>& m = motion_[i];
  Column<S>* column = columns_.data() + link.first_rate;
  if (link.joint < 0) {  // free
    const S* at = y + link.at_q;
    m.A = load3(at);
    m.q_WB = link.rotates ? load4(at + 6) : resting_[link.body].q_WB;
    m.R_WB = rotation_matrix(m.q_WB);
    const bool still = held_[i] != 0;
    m.v = still ? Vec3<S>{} : load3(at + 3);
    m.w = still || !link.rotates ? Vec3<S>{} : m.R_WB * load3(at + 10);
    for (int k = 0; k < 3; ++k) column[k] = {{S(k == 0), S(k == 1), S(k == 2)}, false, {}, {}, S(0), S(0)};
    for (int k = 3; k < link.rates; ++k) column[k] = {atwood::column(m.R_WB, k - 3), true, {}, {}, S(0), S(0)};
    return;
  }
  const S *q = y + link.at_q, *u = y + link.at_u;
  const S driven_q = link.driven_start + t_s * link.driven_rate;
  if (link.driven && driven == DrivenJoints::from_time) {
    q = &driven_q;
    u = &link.driven_rate;
  }
  Quat<S> q_parent, q_joint = link.frame;
  Vec3<S> A_parent, w_parent, v_parent;
  Mat3<S> R_parent;
  if (link.parent >= 0) {
    const LinkMotion<S>& parent = motion_[link.parent];
    q_parent = parent.q_WB;
    R_parent = parent.R_WB;
    A_parent = parent.A;
    w_parent = parent.w;
    v_parent = parent.v;
  } else {
    if (link.root_body >= 0) {
      q_parent = resting_[link.root_body].q_WB;
      A_parent = resting_[link.root_body].p_WB;
    }
    R_parent = rotation_matrix(q_parent);
  }
  if (link.kind == JointKind::hinge || link.kind == JointKind::cylindrical) q_joint = turned_frame(link, q[0]);
  else if (link.kind == JointKind::ball) q_joint = link.frame * load4(q);
  else if (link.kind == JointKind::universal) {
    S sine, cosine;
    real::sin_cos(q[0] / S(2), sine, cosine);
    const Quat<S> inner = turned_frame(link, q[1]);
    q_joint = sum(cosine, inner, sine, pure(link.axis_P) * inner);
  }
  m.q_WB = q_parent * q_joint;
  m.R_WB = rotation_matrix(m.q_WB);
  m.r = m.R_WB * link.to_centre_B;
  m.d = R_parent * link.from_parent_P;
  m.w = w_parent;
  m.c_n = {};
  Vec3<S> sliding;
  const Vec3<S> s = m.R_WB * link.axis_B;
  switch (link.kind) {
    case JointKind::fixed: break;
    case JointKind::hinge:
      column[0].s = s;
      m.w += u[0] * s;
      m.c_n = u[0] * cross(w_parent, s);
      break;
    case JointKind::slider:
    case JointKind::cylindrical: {
      const int along = link.kind == JointKind::slider ? 0 : 1;
      column[along].s = s;
      column[along].angular = false;
      m.d += q[along] * s;
      sliding = u[along] * s;
      if (along == 0) break;
      column[0].s = s;
      m.w += u[0] * s;
      m.c_n = u[0] * cross(w_parent, s);
      break;
    }
    case JointKind::universal:
      column[0].s = R_parent * link.axis_P;
      column[1].s = s;
      m.w += u[0] * column[0].s + u[1] * s;
      m.c_n = u[0] * cross(w_parent, column[0].s) + u[1] * cross(m.w, s);
      break;
    case JointKind::ball: {
      const Vec3<S> relative = m.R_WB * load3(u);
      for (int k = 0; k < 3; ++k) column[k].s = atwood::column(m.R_WB, k);
      m.w += relative;
      m.c_n = cross(w_parent, relative);
      break;
    }
  }
  m.A = A_parent + m.d;
  m.v = v_parent + cross(w_parent, m.d) + sliding;
  m.c_f = cross(w_parent, cross(w_parent, m.d) + S(2) * sliding);
}

template <class S> Vec3<S> Tree<S>::velocity_W(int body, const Vec3<S>& x_W) const {
  if (body < 0 || link_of_body_[body] < 0) return {};
  const LinkMotion<S>& m = motion_[link_of_body_[body]];
  return m.v + cross(m.w, x_W - m.A);
}

template <class S> Vec3<S> Tree<S>::angular_velocity_W(int body) const {
  return body < 0 || link_of_body_[body] < 0 ? Vec3<S>{} : motion_[link_of_body_[body]].w;
}

template <class S> void Tree<S>::write_body(int i, S* to) const {
  const LinkMotion<S>& m = motion_[i];
  store3(m.A + m.r, to);
  store3(m.v + cross(m.w, m.r), to + 3);
  store4(m.q_WB, to + 6);
  store3(transposed_times(m.R_WB, m.w), to + 10);
}

template class Tree<float>;
template class Tree<double>;
template class Tree<long double>;
template class Tree<Quad>;
template class Tree<Dual<double>>;

}  // namespace atwood
