#include "joints/constraint.hpp"

namespace atwood {
namespace {

template <class S> Vec3<S> unit_axis(int k) { return {S(k == 0), S(k == 1), S(k == 2)}; }

template <class S> Vec3<S> normalised(const Vec3<S>& a) { return (S(1) / norm(a)) * a; }

// The nearest value to `before` that differs from `angle` by whole turns.
template <class S> S continued(S angle, S before) {
  const S turn = S(2) * real::atan2(S(0), S(-1));
  return angle + turn * real::floor((before - angle) / turn + S(0.5));
}

// The angle about the unit vector `axis` that turns `from` into `to`, both of any length, as seen along it.
template <class S> S angle_about(const Vec3<S>& axis, const Vec3<S>& from, const Vec3<S>& to) {
  return real::atan2(dot(axis, cross(from, to)), dot(from, to) - dot(axis, from) * dot(axis, to));
}

}  // namespace

template <class S> void directions_across(const Vec3<S>& axis, Vec3<S>& first, Vec3<S>& second) {
  const S x = real::abs(axis.x), y = real::abs(axis.y), z = real::abs(axis.z);
  const Vec3<S> other = unit_axis<S>(x <= y && x <= z ? 0 : y <= z ? 1 : 2);
  first = normalised(cross(other, axis));
  second = cross(axis, first);
}

template <class S> JointConstraint<S> joint_constraint(const Joint& joint, const Quat<S>& parent_attitude) {
  JointConstraint<S> c;
  c.parent = joint.parent;
  c.child = joint.child;
  for (int k = 0; k < 2; ++k) c.anchor[k] = narrow3<S>(joint.anchors_body_m[k]);
  const auto& f = joint.frame_wxyz;
  c.frame = normalised(Quat<S>{S(f[0]), S(f[1]), S(f[2]), S(f[3])});
  const JointKind kind = joint.kind;
  const bool has_axis = kind == JointKind::hinge || kind == JointKind::slider || kind == JointKind::cylindrical;
  const Vec3<S> axis = has_axis ? normalised(narrow3<S>(joint.axis_body)) : unit_axis<S>(2);
  Vec3<S> across[2];
  directions_across(axis, across[0], across[1]);
  const auto in_parent = [&](const Vec3<S>& v) { return rotate(c.frame, v); };
  const auto add = [&](ConditionKind what, const Vec3<S>& a, const Vec3<S>& b, S offset = S(0), S rate = S(0)) {
    c.conditions.push_back({what, a, b, offset, rate});
  };
  // Where the anchors may be.
  if (kind == JointKind::slider || kind == JointKind::cylindrical) {
    for (const Vec3<S>& b : across) add(ConditionKind::slide, {}, b);
  } else {
    for (const Vec3<S>& b : {axis, across[0], across[1]})
      add(ConditionKind::point, rotate(parent_attitude, in_parent(b)), {});
  }
  // How the bodies may be turned.
  if (kind == JointKind::hinge || kind == JointKind::cylindrical) {
    for (const Vec3<S>& a : across) add(ConditionKind::square, in_parent(a), axis);
  } else if (kind == JointKind::fixed || kind == JointKind::slider) {
    add(ConditionKind::square, in_parent(axis), across[0]);
    add(ConditionKind::square, in_parent(across[0]), across[1]);
    add(ConditionKind::square, in_parent(across[1]), axis);
  } else if (kind == JointKind::universal) {
    const Vec3<S> a = normalised(narrow3<S>(joint.axes_body[0])), b = normalised(narrow3<S>(joint.axes_body[1]));
    add(ConditionKind::square, a, b, dot(a, in_parent(b)));
  }
  if (joint.driven_rate) {
    const S start = S(joint.coordinates[0]), rate = S(*joint.driven_rate);
    if (kind == JointKind::hinge) add(ConditionKind::turn, {}, axis, start, rate);
    else if (kind == JointKind::slider) add(ConditionKind::slide, {}, axis, start, rate);
  }
  return c;
}

template <class S>
void constraint_row(const JointConstraint<S>& joint, int i, const TiedBody<S>& parent, const TiedBody<S>& child, S t_s,
                    JointRow<S>& row) {
  const Condition<S>& condition = joint.conditions[i];
  const Vec3<S>&w_p = parent.w_WB, &w_c = child.w_WB;
  row.rate = condition.rate;
  if (condition.kind == ConditionKind::square) {
    const Vec3<S> a = rotate(parent.q_WB, condition.a), b = rotate(child.q_WB, condition.b), t = cross(b, a);
    row.value = dot(a, b) - condition.offset;
    row.on[0] = {{}, -t};
    row.on[1] = {{}, t};
    row.drift = dot(cross(cross(w_c, b), a) + cross(b, cross(w_p, a)), w_c - w_p);
    return;
  }
  if (condition.kind == ConditionKind::turn) {
    const Vec3<S> a = rotate(child.q_WB, condition.b);
    const Quat<S> relative = conjugate(joint.frame) * (conjugate(parent.q_WB) * child.q_WB);
    const Vec3<S> u{relative.x, relative.y, relative.z};
    const S wanted = condition.offset + condition.rate * t_s;
    row.value = continued(S(2) * real::atan2(dot(u, condition.b), relative.w), wanted) - wanted;
    row.on[0] = {{}, -a};
    row.on[1] = {{}, a};
    row.drift = dot(cross(w_c, a), w_c - w_p);
    return;
  }
  const Vec3<S> r_p = rotate(parent.q_WB, joint.anchor[0]), r_c = rotate(child.q_WB, joint.anchor[1]);
  const Vec3<S> d = (child.p_WB - parent.p_WB) + (r_c - r_p);
  const Vec3<S> turning = cross(w_c, cross(w_c, r_c)) - cross(w_p, cross(w_p, r_p));
  if (condition.kind == ConditionKind::point) {
    const Vec3<S>& n = condition.a;
    row.value = dot(n, d);
    row.on[0] = {-n, -cross(r_p, n)};
    row.on[1] = {n, cross(r_c, n)};
    row.drift = dot(n, turning);
    return;
  }
  const Vec3<S> b = rotate(child.q_WB, condition.b);
  const Vec3<S> d_rate = (child.v_WB - parent.v_WB) + (cross(w_c, r_c) - cross(w_p, r_p));
  row.value = dot(b, d) - (condition.offset + condition.rate * t_s);
  row.on[0] = {-b, -cross(r_p, b)};
  row.on[1] = {b, cross(r_c - d, b)};
  const Vec3<S> b_rate = cross(w_c, b);
  row.drift = dot(b, turning) + S(2) * dot(b_rate, d_rate) + dot(cross(w_c, b_rate), d);
}

template <class S>
void coordinates_of(const Joint& joint, const TiedBody<S>& parent, const TiedBody<S>& child, S* q, S* u) {
  const auto& f = joint.frame_wxyz;
  const Quat<S> frame = normalised(Quat<S>{S(f[0]), S(f[1]), S(f[2]), S(f[3])});
  const Quat<S> turned = conjugate(parent.q_WB) * child.q_WB;
  const Vec3<S> w_rel = child.w_WB - parent.w_WB;
  if (joint.kind == JointKind::ball) {
    Quat<S> r = normalised(conjugate(frame) * turned);
    if (r.w * q[0] + r.x * q[1] + r.y * q[2] + r.z * q[3] < S(0)) r = {-r.w, -r.x, -r.y, -r.z};
    store4(r, q);
    store3(rotate_back(child.q_WB, w_rel), u);
    return;
  }
  if (joint.kind == JointKind::universal) {
    const Vec3<S> a1 = normalised(narrow3<S>(joint.axes_body[0])), a2 = normalised(narrow3<S>(joint.axes_body[1]));
    q[0] = continued(angle_about(a1, rotate(frame, a2), rotate(turned, a2)), q[0]);
    q[1] = continued(angle_about(a2, rotate_back(turned, a1), rotate_back(frame, a1)), q[1]);
    // w_rel = a1 u0 + a2 u1 in world axes
    const Vec3<S> first = rotate(parent.q_WB, a1), second = rotate(child.q_WB, a2);
    const S c = dot(first, second), p = dot(first, w_rel), s = dot(second, w_rel), det = S(1) - c * c;
    u[0] = (p - c * s) / det;
    u[1] = (s - c * p) / det;
    return;
  }
  if (joint.kind == JointKind::fixed) return;
  const Vec3<S> axis = normalised(narrow3<S>(joint.axis_body)), axis_W = rotate(child.q_WB, axis);
  const bool turns = joint.kind != JointKind::slider, slides = joint.kind != JointKind::hinge;
  if (turns) {
    const Quat<S> r = conjugate(frame) * turned;
    q[0] = continued(S(2) * real::atan2(dot(axis, Vec3<S>{r.x, r.y, r.z}), r.w), q[0]);
    u[0] = dot(axis_W, w_rel);
  }
  if (!slides) return;
  const int at = turns ? 1 : 0;
  const Vec3<S> r_p = rotate(parent.q_WB, narrow3<S>(joint.anchors_body_m[0])),
                r_c = rotate(child.q_WB, narrow3<S>(joint.anchors_body_m[1]));
  const Vec3<S> d = (child.p_WB - parent.p_WB) + (r_c - r_p);
  const Vec3<S> d_rate = (child.v_WB - parent.v_WB) + (cross(child.w_WB, r_c) - cross(parent.w_WB, r_p));
  q[at] = dot(axis_W, d);
  u[at] = dot(axis_W, d_rate) + dot(cross(child.w_WB, axis_W), d);
}

#define ATWOOD_CONSTRAINT(S)                                                                                 \
  template void directions_across<S>(const Vec3<S>&, Vec3<S>&, Vec3<S>&);                                    \
  template JointConstraint<S> joint_constraint<S>(const Joint&, const Quat<S>&);                             \
  template void constraint_row<S>(const JointConstraint<S>&, int, const TiedBody<S>&, const TiedBody<S>&, S, \
                                  JointRow<S>&);                                                             \
  template void coordinates_of<S>(const Joint&, const TiedBody<S>&, const TiedBody<S>&, S*, S*);
ATWOOD_CONSTRAINT(float)
ATWOOD_CONSTRAINT(double)
ATWOOD_CONSTRAINT(long double)
ATWOOD_CONSTRAINT(Quad)
#undef ATWOOD_CONSTRAINT

}  // namespace atwood
