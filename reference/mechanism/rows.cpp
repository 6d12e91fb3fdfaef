// The constraints of each kind of joint, their derivatives, and the coordinates that poses give.
//
// r_p, r_c: from the centres of mass to the anchors; x_p = p_p + r_p, x_c = p_c + r_c; d = x_c - x_p. For a direction b
// fixed in the child:
//   (b . d)'  = b . (v_c + w_c x (r_c - d) - v_p - w_p x r_p)                    because w_c x b . d = w_c . b x d
//   (b . d)'' = the same with accelerations + b . (w_c x (w_c x r_c) - w_p x (w_p x r_p)) + 2 (w_c x b) . d'
//               + (w_c x (w_c x b)) . d
#include <cmath>

#include "mechanism/model.hpp"

namespace atwood::mechanism {

namespace {

template <class S> struct Frames {
  const Motion<S>&p, &c;
  Triple<S> r_p, r_c, d, d_rate, centripetal;  // centripetal: w_c x (w_c x r_c) - w_p x (w_p x r_p)
  Triple<S> w;                                 // w_c - w_p
  Frames(const JointModel<S>& joint, const std::vector<Motion<S>>& motions)
      : p(motions[joint.parent]), c(motions[joint.child]) {
    r_p = rotate(p.q, joint.anchor_parent);
    r_c = rotate(c.q, joint.anchor_child);
    d = (c.p + r_c) - (p.p + r_p);
    d_rate = (c.v + cross(c.w, r_c)) - (p.v + cross(p.w, r_p));
    centripetal = cross(c.w, cross(c.w, r_c)) - cross(p.w, cross(p.w, r_p));
    w = c.w - p.w;
  }
};

template <class S> Row<S> row_between(const JointModel<S>& joint) {
  Row<S> made;
  made.a = joint.parent;
  made.b = joint.child;
  return made;
}

// d along an axis of the world.
template <class S> Row<S> world_row(const JointModel<S>& joint, const Frames<S>& at, int k) {
  Row<S> made = row_between(joint);
  Triple<S> e{};
  e[k] = 1;
  made.lb = e;
  made.ab = cross(at.r_c, e);
  made.la = S(-1) * e;
  made.aa = S(-1) * cross(at.r_p, e);
  made.gamma = at.centripetal[k];
  made.residual = at.d[k];
  return made;
}

// d along b, fixed in the child (given in world axes).
template <class S> Row<S> sliding_row(const JointModel<S>& joint, const Frames<S>& at, const Triple<S>& b) {
  Row<S> made = row_between(joint);
  made.lb = b;
  made.ab = cross(at.r_c - at.d, b);
  made.la = S(-1) * b;
  made.aa = S(-1) * cross(at.r_p, b);
  const Triple<S> b_rate = cross(at.c.w, b);
  made.gamma = dot(b, at.centripetal) + 2 * dot(b_rate, at.d_rate) + dot(cross(at.c.w, b_rate), at.d);
  made.residual = dot(b, at.d);
  return made;
}

// The relative angular velocity along b, fixed in the child.
template <class S> Row<S> turning_row(const JointModel<S>& joint, const Frames<S>& at, const Triple<S>& b) {
  Row<S> made = row_between(joint);
  made.ab = b;
  made.aa = S(-1) * b;
  made.gamma = dot(cross(at.c.w, b), at.w);
  return made;
}

// Twice the vector part of the rotation that turns the parent's F into the child's axes, world axes: near the identity
// the rotation vector.
template <class S> Triple<S> attitude_error(const JointModel<S>& joint, const Frames<S>& at) {
  Quaternion<S> e = product(at.c.q, conjugate(product(at.p.q, joint.frame)));
  if (e[0] < 0)
    for (S& part : e) part = -part;
  return {2 * e[1], 2 * e[2], 2 * e[3]};
}

template <class S> S angle_about(const Triple<S>& axis, const Quaternion<S>& q) {
  return 2 * dynamics::atan2(dot(axis, Triple<S>{q[1], q[2], q[3]}), q[0]);
}

template <class S> Quaternion<S> relative_attitude(const JointModel<S>& joint, const Frames<S>& at) {
  return product(conjugate(product(at.p.q, joint.frame)), at.c.q);
}

template <class S> void universal_axes(const JointModel<S>& joint, const Frames<S>& at, Triple<S>& a1, Triple<S>& a2) {
  a1 = rotate(at.p.q, joint.first);
  a2 = rotate(at.c.q, joint.second);
}

}  // namespace

template <class S>
void add_constraint_rows(const Model<S>& model, int index, const std::vector<Motion<S>>& motions, const S& t_s,
                         const Memory& memory, std::vector<Row<S>>& rows) {
  const JointModel<S>& joint = model.joints[index];
  const Frames<S> at(joint, motions);
  const Triple<S> n = rotate(at.c.q, joint.axis);
  const std::size_t begin = rows.size();
  const bool slides = joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical;
  if (slides) {
    for (const Triple<S>& b : joint.across) rows.push_back(sliding_row(joint, at, rotate(at.c.q, b)));
  } else {
    for (int k = 0; k < 3; ++k) rows.push_back(world_row(joint, at, k));
  }
  if (joint.kind == JointKind::fixed || joint.kind == JointKind::slider) {
    const Triple<S> error = attitude_error(joint, at);
    for (int k = 0; k < 3; ++k) {
      Row<S> row = row_between(joint);
      row.ab[k] = 1;
      row.aa[k] = -1;
      row.residual = error[k];
      rows.push_back(row);
    }
  }
  if (joint.kind == JointKind::hinge || joint.kind == JointKind::cylindrical) {
    const Triple<S> tilt = cross(rotate(product(at.p.q, joint.frame), joint.axis), n);
    for (const Triple<S>& b : joint.across) {
      const Triple<S> b_W = rotate(at.c.q, b);
      Row<S> row = turning_row(joint, at, b_W);
      row.residual = dot(b_W, tilt);
      rows.push_back(row);
    }
  }
  if (joint.kind == JointKind::universal) {  // (a1 . a2)' = (w_c - w_p) . (a2 x a1)
    Triple<S> a1, a2;
    universal_axes(joint, at, a1, a2);
    Row<S> row = row_between(joint);
    row.ab = cross(a2, a1);
    row.aa = S(-1) * row.ab;
    row.gamma = dot(cross(cross(at.c.w, a2), a1) + cross(a2, cross(at.p.w, a1)), at.w);
    row.residual = dot(a1, a2) - joint.cosine;
    rows.push_back(row);
  }
  if (joint.driven) {
    Row<S> row = rate_rows(model, index, motions)[0];
    row.residual = coordinates(model, index, motions, memory)[0] - (joint.start + joint.rate * t_s);
    row.bias = joint.rate;
    rows.push_back(row);
  }
  for (std::size_t k = begin; k < rows.size(); ++k) rows[k].joint = index;
}

template <class S>
std::vector<Row<S>> rate_rows(const Model<S>& model, int index, const std::vector<Motion<S>>& motions) {
  const JointModel<S>& joint = model.joints[index];
  const Frames<S> at(joint, motions);
  const Triple<S> n = rotate(at.c.q, joint.axis);
  std::vector<Row<S>> made;
  switch (joint.kind) {
    case JointKind::fixed: break;
    case JointKind::hinge: made.push_back(turning_row(joint, at, n)); break;
    case JointKind::slider: made.push_back(sliding_row(joint, at, n)); break;
    case JointKind::cylindrical:
      made.push_back(turning_row(joint, at, n));
      made.push_back(sliding_row(joint, at, n));
      break;
    case JointKind::universal: {  // w = a1 u0 + a2 u1: the dual vectors of a1 and a2 in their plane
      Triple<S> a1, a2;
      universal_axes(joint, at, a1, a2);
      const S c = dot(a1, a2), inverse = 1 / (1 - c * c);
      made.push_back(turning_row(joint, at, inverse * (a1 - c * a2)));
      made.push_back(turning_row(joint, at, inverse * (a2 - c * a1)));
      break;
    }
    case JointKind::ball:
      for (int k = 0; k < 3; ++k) {
        Triple<S> e{};
        e[k] = 1;
        made.push_back(turning_row(joint, at, rotate(at.c.q, e)));
      }
      break;
  }
  return made;
}

template <class S>
std::array<S, 4> coordinates(const Model<S>& model, int index, const std::vector<Motion<S>>& motions,
                             const Memory& memory) {
  const JointModel<S>& joint = model.joints[index];
  const std::array<double, 4>& near = memory.joints[index];
  const Frames<S> at(joint, motions);
  const Triple<S> n = rotate(at.c.q, joint.axis);
  std::array<S, 4> q{};
  switch (joint.kind) {
    case JointKind::fixed: break;
    case JointKind::hinge: q[0] = nearest_branch(angle_about(joint.axis, relative_attitude(joint, at)), near[0]); break;
    case JointKind::slider: q[0] = dot(n, at.d); break;
    case JointKind::cylindrical:
      q[0] = nearest_branch(angle_about(joint.axis, relative_attitude(joint, at)), near[0]);
      q[1] = dot(n, at.d);
      break;
    case JointKind::universal: {  // exp(a1 q0) turns F a2 into the child's a2 seen from the parent
      const Quaternion<S> relative = product(conjugate(at.p.q), at.c.q);
      const Triple<S> from = cross(joint.first, joint.second_at_zero);
      const Triple<S> to = cross(joint.first, rotate(relative, joint.second));
      q[0] = nearest_branch<S>(dynamics::atan2(dot(joint.first, cross(from, to)), dot(from, to)), near[0]);
      const Quaternion<S> first = product(turn_about(joint.first, q[0]), joint.frame);
      q[1] = nearest_branch(angle_about(joint.second, product(conjugate(first), relative)), near[1]);
      break;
    }
    case JointKind::ball: {
      const Quaternion<S> e = relative_attitude(joint, at);
      double along = 0;
      for (int k = 0; k < 4; ++k) along += static_cast<double>(e[k]) * near[k];
      for (int k = 0; k < 4; ++k) q[k] = along < 0 ? -e[k] : e[k];
      break;
    }
  }
  return q;
}

template <class S> std::array<S, 3> rates(const Model<S>& model, int index, const std::vector<Motion<S>>& motions) {
  std::array<S, 3> u{};
  const std::vector<Row<S>> rows = rate_rows(model, index, motions);
  for (std::size_t k = 0; k < rows.size(); ++k) u[k] = velocity_of(rows[k], motions);
  return u;
}

template <class S>
std::array<S, 3> applied(const Model<S>& model, int index, const std::array<S, 4>& q, const std::array<S, 3>& u,
                         const S& t_s, double interval_s) {
  std::array<S, 3> made{};
  const bool ball = model.joints[index].kind == JointKind::ball;
  for (const JointForce& force : model.scene->joint_forces) {
    if (const auto* spring = std::get_if<JointSpring>(&force); spring && spring->joint == index) {
      if (ball) {
        for (int k = 0; k < 3; ++k) made[k] -= S(spring->damping) * u[k];
        continue;
      }
      const int k = spring->coordinate;
      made[k] -= S(spring->stiffness) * (q[k] - S(spring->rest)) + S(spring->damping) * u[k];
    }
    if (const auto* torque = std::get_if<JointTorque>(&force); torque && torque->joint == index) {
      bool on = torque->on_s.empty();
      for (const Interval& span : torque->on_s) on = on || (span.from_s <= interval_s && interval_s < span.to_s);
      if (!on) continue;
      const S phase = S(torque->angular_frequency_rad_per_s) * t_s + S(torque->phase_rad);
      made[torque->coordinate] += S(torque->torque) * dynamics::cos(phase);
    }
  }
  return made;
}

#define ATWOOD_ROWS(S)                                                                                                \
  template void add_constraint_rows(const Model<S>&, int, const std::vector<Motion<S>>&, const S&, const Memory&,     \
                                    std::vector<Row<S>>&);                                                            \
  template std::vector<Row<S>> rate_rows(const Model<S>&, int, const std::vector<Motion<S>>&);                        \
  template std::array<S, 4> coordinates(const Model<S>&, int, const std::vector<Motion<S>>&, const Memory&);          \
  template std::array<S, 3> rates(const Model<S>&, int, const std::vector<Motion<S>>&);                               \
  template std::array<S, 3> applied(const Model<S>&, int, const std::array<S, 4>&, const std::array<S, 3>&, const S&, \
                                    double);
ATWOOD_ROWS(double)
ATWOOD_ROWS(long double)
ATWOOD_ROWS(__float128)
#undef ATWOOD_ROWS

}  // namespace atwood::mechanism
