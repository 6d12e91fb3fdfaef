#include "mechanism/reduced.hpp"

#include <algorithm>

namespace atwood::mechanism {

// Poses and velocities from the root to the leaves, and the axes of all rates.
template <class S> typename Reduced<S>::Tree Reduced<S>::kinematics(const S* y) const {
  Tree made;
  made.now.resize(model_.world + 1);
  made.dofs.resize(rates_);
  const S* u = y + coordinates_;
  for (int i = 0; i < model_.world; ++i) {
    Motion<S>& body = made.now[i];
    if (model_.placing[i] >= 0) continue;
    if (body_q_[i] < 0) {
      const Body& given = model_.scene->bodies[i];
      body.p = dynamics::widen<S>(given.position_m);
      for (int k = 0; k < 4; ++k) body.q[k] = S(given.orientation_wxyz[k]);
      body.q = normalised(body.q);
      continue;
    }
    body.p = dynamics::read3(y + body_q_[i]);
    body.v = dynamics::read3(u + body_u_[i]);
    if (model_.turns[i]) {
      std::copy_n(y + body_q_[i] + 3, 4, body.q.begin());
      body.q = normalised(body.q);
    } else {
      for (int k = 0; k < 4; ++k) body.q[k] = S(model_.scene->bodies[i].orientation_wxyz[k]);
      body.q = normalised(body.q);
    }
    for (int k = 0; k < dof_count_[i]; ++k) {
      Triple<S> e{};
      e[k % 3] = 1;
      made.dofs[body_u_[i] + k] = k < 3 ? Dof{false, e, {}} : Dof{true, rotate(body.q, e), body.p};
      if (k >= 3) body.w += u[body_u_[i] + k] * made.dofs[body_u_[i] + k].s;
    }
  }
  for (const int j : model_.tree) {
    const JointModel<S>& joint = model_.joints[j];
    const Motion<S>& p = made.now[joint.parent];
    Motion<S>& c = made.now[joint.child];
    const S* q = y + joint_q_[j];
    const S* rate = u + joint_u_[j];
    Dof* dofs = made.dofs.data() + joint_u_[j];
    const Triple<S> x_p = p.p + rotate(p.q, joint.anchor_parent);
    Triple<S> slide{}, slide_axis{};
    S slide_rate{};
    switch (joint.kind) {
      case JointKind::fixed:
      case JointKind::slider: c.q = product(p.q, joint.frame); break;
      case JointKind::hinge:
      case JointKind::cylindrical: c.q = product(product(p.q, joint.frame), turn_about(joint.axis, q[0])); break;
      case JointKind::universal:
        c.q =
            product(product(product(p.q, turn_about(joint.first, q[0])), joint.frame), turn_about(joint.second, q[1]));
        break;
      case JointKind::ball: c.q = product(product(p.q, joint.frame), normalised<S>({q[0], q[1], q[2], q[3]})); break;
    }
    const Triple<S> n = rotate(c.q, joint.axis);
    if (joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical) {
      const int k = joint.kind == JointKind::slider ? 0 : 1;
      slide = q[k] * n;
      slide_axis = n;
      slide_rate = rate[k];
    }
    const Triple<S> x_c = x_p + slide, r_c = rotate(c.q, joint.anchor_child);
    c.p = x_c - r_c;
    c.w = p.w;
    switch (joint.kind) {
      case JointKind::fixed: break;
      case JointKind::slider: dofs[0] = {false, n, {}}; break;
      case JointKind::hinge: dofs[0] = {true, n, x_c}; break;
      case JointKind::cylindrical:
        dofs[0] = {true, n, x_c};
        dofs[1] = {false, n, {}};
        break;
      case JointKind::universal:
        dofs[0] = {true, rotate(p.q, joint.first), x_c};
        dofs[1] = {true, rotate(c.q, joint.second), x_c};
        break;
      case JointKind::ball:
        for (int k = 0; k < 3; ++k) {
          Triple<S> e{};
          e[k] = 1;
          dofs[k] = {true, rotate(c.q, e), x_c};
        }
        break;
    }
    for (int k = 0; k < atwood::rate_count(joint.kind); ++k)
      if (dofs[k].turns) c.w += rate[k] * dofs[k].s;
    c.v = p.v + cross(p.w, x_c - p.p) + slide_rate * slide_axis - cross(c.w, r_c);
  }
  return made;
}

template <class S> std::vector<Motion<S>> Reduced<S>::motions(const S* y) const { return kinematics(y).now; }

template <class S>
std::vector<Acceleration<S>> Reduced<S>::accelerations(const Tree& tree, const S* y, const S* rates_rate) const {
  std::vector<Acceleration<S>> made(model_.world + 1);
  const S* u = y + coordinates_;
  const auto added = [&](int dof) { return rates_rate == nullptr ? S(0) : rates_rate[dof]; };
  for (int i = 0; i < model_.world; ++i)
    for (int k = 0; body_u_[i] >= 0 && k < dof_count_[i]; ++k)
      (k < 3 ? made[i].a : made[i].alpha) += added(body_u_[i] + k) * tree.dofs[body_u_[i] + k].s;
  for (const int j : model_.tree) {
    const JointModel<S>& joint = model_.joints[j];
    const Motion<S>&p = tree.now[joint.parent], &c = tree.now[joint.child];
    const Acceleration<S>& a_p = made[joint.parent];
    Acceleration<S>& a_c = made[joint.child];
    const Triple<S> r_c = rotate(c.q, joint.anchor_child), arm = c.p + r_c - p.p;
    a_c.alpha = a_p.alpha;
    Triple<S> sliding{};
    for (int k = 0; k < atwood::rate_count(joint.kind); ++k) {
      const int dof = joint_u_[j] + k;
      const Triple<S>& s = tree.dofs[dof].s;
      if (!tree.dofs[dof].turns) {
        sliding += added(dof) * s + (S(2) * u[dof]) * cross(p.w, s);
        continue;
      }
      // The axis is carried by the parent (first of a universal joint, hinge) or by the child.
      const bool by_child = joint.kind == JointKind::ball || (joint.kind == JointKind::universal && k == 1);
      a_c.alpha += added(dof) * s + u[dof] * cross(by_child ? c.w : p.w, s);
    }
    a_c.a = a_p.a + cross(a_p.alpha, arm) + cross(p.w, cross(p.w, arm)) + sliding - cross(a_c.alpha, r_c) -
            cross(c.w, cross(c.w, r_c));
  }
  return made;
}

// M_jk for k at or above j: rate k sees the momentum that rate j alone gives to the subtree of its body.
template <class S> Envelope<S> Reduced<S>::mass_matrix(const Tree& tree) const {
  const int n = model_.world;
  struct Composite {
    S mass{};
    Triple<S> c{};
    Matrix<S> J{};
  };
  std::vector<Composite> composite(n + 1);
  for (int i = 0; i < n; ++i) {
    if (!model_.mobile[i]) continue;
    composite[i].mass = model_.mass[i];
    composite[i].c = tree.now[i].p;
    if (!model_.turns[i]) continue;
    for (int k = 0; k < 3; ++k) {
      Triple<S> e{};
      e[k] = 1;
      const Triple<S> column = turned(model_.inertia[i], tree.now[i].q, e);
      for (int l = 0; l < 3; ++l) composite[i].J[3 * l + k] = column[l];
    }
  }
  for (auto j = model_.tree.rbegin(); j != model_.tree.rend(); ++j) {
    const Composite& child = composite[model_.joints[*j].child];
    const int p = model_.joints[*j].parent;
    if (!model_.mobile[p]) continue;
    Composite& parent = composite[p];
    const S mass = parent.mass + child.mass, reduced = parent.mass * child.mass / mass;
    const Triple<S> d = child.c - parent.c;
    const S d2 = dot(d, d);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        parent.J[3 * a + b] += child.J[3 * a + b] + reduced * ((a == b ? d2 : S(0)) - d[a] * d[b]);
    parent.c += (child.mass / mass) * d;
    parent.mass = mass;
  }
  Envelope<S> M;
  M.reset(rates_);
  M.first = first_;
  for (int i = 0; i < n; ++i)
    for (int a = 0; a < dof_count_[i]; ++a) {
      const int j = dof_begin_[i] + a;
      const Dof& dof = tree.dofs[j];
      const Composite& of = composite[i];
      const Triple<S> P = of.mass * (dof.turns ? cross(dof.s, of.c - dof.o) : dof.s);
      const Triple<S> H = dof.turns ? multiply(of.J, dof.s) : Triple<S>{};  // about the centre of mass of the subtree
      for (int b = i; b >= 0 && b < n; b = parent_[b])
        for (int c = 0; c < dof_count_[b]; ++c) {
          const int k = dof_begin_[b] + c;
          if (k > j) continue;
          const Dof& other = tree.dofs[k];
          M(j, k) = other.turns ? dot(other.s, H + cross(of.c - other.o, P)) : dot(other.s, P);
        }
    }
  for (std::size_t k = 0; k < rope_u_.size(); ++k)
    if (rope_u_[k] >= 0) M(rope_u_[k], rope_u_[k]) = model_.ropes[k].inertia;
  return M;
}

// J^T loads, from the leaves to the root.
template <class S> std::vector<S> Reduced<S>::pull_back(const Tree& tree, std::vector<Wrench<S>> loads) const {
  std::vector<S> made(rates_, S(0));
  const auto take = [&](int body) {
    for (int k = dof_begin_[body]; k < dof_begin_[body] + dof_count_[body]; ++k) {
      const Dof& dof = tree.dofs[k];
      made[k] = dof.turns ? dot(dof.s, loads[body].torque + cross(tree.now[body].p - dof.o, loads[body].force))
                          : dot(dof.s, loads[body].force);
    }
  };
  for (auto j = model_.tree.rbegin(); j != model_.tree.rend(); ++j) {
    const int c = model_.joints[*j].child, p = model_.joints[*j].parent;
    take(c);
    loads[p].force += loads[c].force;
    loads[p].torque += loads[c].torque + cross(tree.now[c].p - tree.now[p].p, loads[c].force);
  }
  for (int i = 0; i < model_.world; ++i)
    if (body_u_[i] >= 0) take(i);
  return made;
}

template <class S> std::vector<S> Reduced<S>::pull_back(const Tree& tree, const Row<S>& row) const {
  std::vector<S> made(rates_, S(0));
  for (const bool second : {false, true}) {
    const Triple<S>&l = second ? row.lb : row.la, &a = second ? row.ab : row.aa;
    const int body = second ? row.b : row.a;
    for (int b = body; b >= 0 && b < model_.world; b = parent_[b])
      for (int k = dof_begin_[b]; k < dof_begin_[b] + dof_count_[b]; ++k) {
        const Dof& dof = tree.dofs[k];
        made[k] += dof.turns ? dot(dof.s, a + cross(tree.now[body].p - dof.o, l)) : dot(dof.s, l);
      }
  }
  if (row.rope >= 0) made[rope_u_[row.rope]] += row.cp;
  return made;
}

#define ATWOOD_TREE(S)                                                                                    \
  template typename Reduced<S>::Tree Reduced<S>::kinematics(const S*) const;                              \
  template std::vector<Motion<S>> Reduced<S>::motions(const S*) const;                                    \
  template std::vector<Acceleration<S>> Reduced<S>::accelerations(const Tree&, const S*, const S*) const; \
  template Envelope<S> Reduced<S>::mass_matrix(const Tree&) const;                                        \
  template std::vector<S> Reduced<S>::pull_back(const Tree&, std::vector<Wrench<S>>) const;               \
  template std::vector<S> Reduced<S>::pull_back(const Tree&, const Row<S>&) const;
ATWOOD_TREE(double)
ATWOOD_TREE(long double)
ATWOOD_TREE(__float128)
#undef ATWOOD_TREE

}  // namespace atwood::mechanism
