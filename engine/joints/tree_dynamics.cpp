// Dynamics of trees: the articulated-body algorithm, its solves, and the reactions.
#include "math/dual.hpp"  // before templates that use it

#include "joints/tree.hpp"

#include <algorithm>

namespace atwood {
namespace {

// The accelerations of link i at constant rates, from its parent's.
template <class S>
void accelerate_with_parent(const std::vector<Link<S>>& links, std::vector<LinkMotion<S>>& motions, int i) {
  const Link<S>& link = links[i];
  LinkMotion<S>& m = motions[i];
  m.alpha = m.a = {};
  if (link.joint < 0) return;
  m.alpha = m.c_n;
  m.a = m.c_f;
  if (link.parent < 0) return;
  const LinkMotion<S>& parent = motions[link.parent];
  m.alpha += parent.alpha;
  m.a += parent.a + cross(parent.alpha, m.d);
}

}  // namespace

// The inertia about A, and the wrench that motion and external forces make at zero acceleration.
template <class S> void Tree<S>::start_link(int i, const Load<S>* loads) {
  const Link<S>& link = links_[i];
  const LinkMotion<S>& m = motion_[i];
  const Load<S>& load = loads[link.body];
  Articulated<S>& I = articulated_[i];
  const S mass = link.mass_kg;
  I.J = rotated(m.R_WB, link.J_B);
  I.H = cross_matrix(mass * m.r);
  I.M = {mass, S(0), S(0), mass, S(0), mass};
  const Vec3<S> force = mass * load.acceleration_W + load.force_W;
  I.n = cross(m.w, I.J * m.w) - cross(m.r, force);
  if (link.rotates) I.n -= m.R_WB * load.torque_B;
  I.f = mass * cross(m.w, cross(m.w, m.r)) - force;
}

template <class S> void Tree<S>::eliminate_link(int i, const S* applied) {
  const Link<S>& link = links_[i];
  if (link.driven || held_[i]) return;
  Articulated<S>& I = articulated_[i];
  for (int k = link.first_rate; k < link.first_rate + link.rates; ++k) {
    Column<S>& column = columns_[k];
    const Vec3<S> s = column.s;
    S D, along;
    if (column.angular) {
      column.U_n = I.J * s;
      column.U_f = transposed_times(I.H, s);
      D = dot(s, column.U_n);
      along = dot(s, I.n);
    } else {
      column.U_n = I.H * s;
      column.U_f = I.M * s;
      D = dot(s, column.U_f);
      along = dot(s, I.f);
    }
    column.inverse_D = S(1) / D;
    column.force = (applied == nullptr ? S(0) : applied[k]) - along;
    add_outer(I.J, -column.inverse_D, column.U_n);
    add_outer(I.H, -column.inverse_D, column.U_n, column.U_f);
    add_outer(I.M, -column.inverse_D, column.U_f);
    const S share = column.force * column.inverse_D;
    I.n += share * column.U_n;
    I.f += share * column.U_f;
  }
}

// About the parent's A, from which the child's is at d: with X = (1, 0; -[d], 1) the inertia becomes X^T I X,
//   M' = M    H' = H + [d] M    J' = J + [d] H^T - H' [d]
template <class S> void Tree<S>::add_to_parent(int i) {
  const LinkMotion<S>& m = motion_[i];
  const Articulated<S>& I = articulated_[i];
  Articulated<S>& to = articulated_[links_[i].parent];
  const Vec3<S> d = m.d;
  const Vec3<S> f = I.f + transposed_times(I.H, m.c_n) + I.M * m.c_f;
  to.n += I.n + I.J * m.c_n + I.H * m.c_f + cross(d, f);
  to.f += f;
  const Vec3<S> Mx{I.M.xx, I.M.xy, I.M.xz}, My{I.M.xy, I.M.yy, I.M.yz}, Mz{I.M.xz, I.M.yz, I.M.zz};
  const Mat3<S> H{I.H.x + (d.y * Mz - d.z * My), I.H.y + (d.z * Mx - d.x * Mz), I.H.z + (d.x * My - d.y * Mx)};
  const Vec3<S> tx = cross(d, I.H.x), ty = cross(d, I.H.y), tz = cross(d, I.H.z);  // columns of [d] H^T
  const Vec3<S> bx = cross(d, H.x), by = cross(d, H.y), bz = cross(d, H.z);        // rows of -H' [d]
  to.M += I.M;
  to.H += H;
  to.J += I.J;
  to.J += Sym3<S>{tx.x + bx.x, ty.x + bx.y, tz.x + bx.z, ty.y + by.y, tz.y + by.z, tz.z + bz.z};
}

template <class S> void Tree<S>::accelerate_link(int i, S* du) {
  const Link<S>& link = links_[i];
  LinkMotion<S>& m = motion_[i];
  accelerate_with_parent(links_, motion_, i);
  for (int k = link.first_rate + link.rates - 1; k >= link.first_rate; --k) {
    du[k] = S(0);
    if (link.driven || held_[i]) continue;
    const Column<S>& column = columns_[k];
    du[k] = (column.force - (dot(column.U_n, m.alpha) + dot(column.U_f, m.a))) * column.inverse_D;
    (column.angular ? m.alpha : m.a) += du[k] * column.s;
  }
}

template <class S> void Tree<S>::accelerations(const Load<S>* loads, const S* applied, S* du) {
  const int count = static_cast<int>(links_.size());
  for (int i = 0; i < count; ++i) start_link(i, loads);
  for (int i = count - 1; i >= 0; --i) {
    eliminate_link(i, applied);
    if (links_[i].parent >= 0) add_to_parent(i);
  }
  for (int i = 0; i < count; ++i) accelerate_link(i, du);
}

template <class S> void Tree<S>::solve(const S* force, S* du) {
  const int count = static_cast<int>(links_.size());
  for (Twist& r : response_) r = {};  // first the wrench (n, f), then the acceleration
  for (int i = count - 1; i >= 0; --i) {
    const Link<S>& link = links_[i];
    Twist& p = response_[i];
    if (!link.driven && !held_[i])
      for (int k = link.first_rate; k < link.first_rate + link.rates; ++k) {
        Column<S>& column = columns_[k];
        column.force = force[k] - dot(column.s, column.angular ? p.angular : p.linear);
        const S share = column.force * column.inverse_D;
        p.angular += share * column.U_n;
        p.linear += share * column.U_f;
      }
    if (link.parent < 0) continue;
    Twist& to = response_[link.parent];
    to.angular += p.angular + cross(motion_[i].d, p.linear);
    to.linear += p.linear;
  }
  for (int i = 0; i < count; ++i) {
    const Link<S>& link = links_[i];
    Twist& response = response_[i];
    response = {};
    if (link.parent >= 0) {
      const Twist& parent = response_[link.parent];
      response = {parent.angular, parent.linear + cross(parent.angular, motion_[i].d)};
    }
    for (int k = link.first_rate + link.rates - 1; k >= link.first_rate; --k) {
      du[k] = S(0);
      if (link.driven || held_[i]) continue;
      const Column<S>& column = columns_[k];
      du[k] =
          (column.force - (dot(column.U_n, response.angular) + dot(column.U_f, response.linear))) * column.inverse_D;
      (column.angular ? response.angular : response.linear) += du[k] * column.s;
    }
  }
}

template <class S>
void Tree<S>::add_wrench(int body, const Vec3<S>& x_W, const Vec3<S>& force_W, const Vec3<S>& torque_W,
                         S* generalised) const {
  if (body < 0) return;
  for (int i = link_of_body_[body]; i >= 0; i = links_[i].parent) {
    const Link<S>& link = links_[i];
    const Vec3<S> moment = torque_W + cross(x_W - motion_[i].A, force_W);
    for (int k = link.first_rate; k < link.first_rate + link.rates; ++k)
      generalised[k] += dot(columns_[k].s, columns_[k].angular ? moment : force_W);
  }
}

template <class S> void Tree<S>::accelerate_bodies(const S* du) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link<S>& link = links_[i];
    LinkMotion<S>& m = motion_[i];
    accelerate_with_parent(links_, motion_, static_cast<int>(i));
    for (int k = link.first_rate; k < link.first_rate + link.rates; ++k)
      (columns_[k].angular ? m.alpha : m.a) += du[k] * columns_[k].s;
  }
}

template <class S> Vec3<S> Tree<S>::acceleration_W(int body, const Vec3<S>& x_W) const {
  if (body < 0 || link_of_body_[body] < 0) return {};
  const LinkMotion<S>& m = motion_[link_of_body_[body]];
  const Vec3<S> arm = x_W - m.A;
  return m.a + cross(m.alpha, arm) + cross(m.w, cross(m.w, arm));
}

template <class S> Vec3<S> Tree<S>::angular_acceleration_W(int body) const {
  return body < 0 || link_of_body_[body] < 0 ? Vec3<S>{} : motion_[link_of_body_[body]].alpha;
}

// From the leaves inwards: a joint gives its link what the link's motion needs, less what acts on it from outside.
template <class S> void Tree<S>::reactions(const Load<S>* loads, const JointWrench* wrenches) {
  const int count = static_cast<int>(links_.size());
  for (int i = 0; i < count; ++i) {
    start_link(i, loads);
    LinkMotion<S>& m = motion_[i];
    const Articulated<S>& I = articulated_[i];
    m.n = I.n + I.J * m.alpha + I.H * m.a;
    m.f = I.f + transposed_times(I.H, m.alpha) + I.M * m.a;
    if (wrenches == nullptr) continue;
    m.n -= wrenches[i].moment_W;
    m.f -= wrenches[i].force_W;
  }
  for (int i = count - 1; i >= 0; --i) {
    if (links_[i].parent < 0) continue;
    LinkMotion<S>& to = motion_[links_[i].parent];
    to.n += motion_[i].n + cross(motion_[i].d, motion_[i].f);
    to.f += motion_[i].f;
  }
}

// Free directions of one joint are orthogonal, but for the two axes of a universal joint: there the torque that does no
// work is along their normal.
template <class S> auto Tree<S>::constraint_wrench(int i, const S* applied) const -> JointWrench {
  const Link<S>& link = links_[i];
  JointWrench wrench{motion_[i].f, motion_[i].n};
  if (link.joint < 0) return {};
  const Column<S>* column = columns_.data() + link.first_rate;
  if (link.kind == JointKind::universal) {
    const Vec3<S> normal = cross(column[0].s, column[1].s);
    wrench.moment_W = (dot(normal, wrench.moment_W) / dot(normal, normal)) * normal;
    return wrench;
  }
  if (link.kind == JointKind::ball) {
    wrench.moment_W = {};
    return wrench;
  }
  for (int k = 0; k < link.rates; ++k) {
    Vec3<S>& of = column[k].angular ? wrench.moment_W : wrench.force_W;
    const S along = link.driven ? (applied == nullptr ? S(0) : applied[link.first_rate + k]) : dot(column[k].s, of);
    of -= along * column[k].s;
  }
  return wrench;
}

template class Tree<float>;
template class Tree<double>;
template class Tree<long double>;
template class Tree<Quad>;
template class Tree<Dual<double>>;

}  // namespace atwood
