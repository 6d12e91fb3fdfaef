// The equations of closed loops in a plane (joints/planar_loops.hpp), of one state or of eight at once. `lane`: 0, or
// WholePack of the width that the kernel is built for.
#pragma once

#include "joints/planar_loops.hpp"
#include "joints/planar_rates_kernel.hpp"

namespace atwood {

// The vector v, given at coordinates 0, of the end's link; of what is at rest, v itself.
template <class S>
template <class V>
ATWOOD_INLINE auto PlanarLoops<S>::arm_of(const End& end, const Pair& v, const Work<V>& work) const -> PairOf<V> {
  if (end.link < 0) return {in_all_lanes<V>(v.x), in_all_lanes<V>(v.y)};
  const PairOf<V>& z = work.links[end.link].z;
  return {z.x * v.x - z.y * v.y, z.x * v.y + z.y * v.x};
}

// Angles, poses and velocities of the links' points A, after PlanarRates::start_links().
template <class S>
template <class States, class V>
ATWOOD_INLINE void PlanarLoops<S>::locate(const States& y, DrivenJoints driven, Work<V>& work) const {
  const V zero = in_all_lanes<V>(S(0));
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const auto& link = planar_.links_[i];
    const State<V>& m = work.links[i];
    LinkPose<V> from{zero, {in_all_lanes<V>(bodies_[i].origin.x), in_all_lanes<V>(bodies_[i].origin.y)}, {zero, zero}};
    V w0 = zero;
    if (link.parent >= 0) {
      from = work.poses[link.parent];
      w0 = work.links[link.parent].w;
    }
    LinkPose<V>& to = work.poses[i];
    to.angle = from.angle;
    to.A = {from.A.x + m.d.x, from.A.y + m.d.y};
    to.v = {from.v.x - w0 * m.d.y, from.v.y + w0 * m.d.x};
    const bool by_time = link.driven && driven == DrivenJoints::from_time;
    if (link.turns) {
      const V q = by_time ? link.driven_start + y.time() * link.driven_rate : y.at(link.at_q);
      to.angle = from.angle + link.sign * q;
    } else if (link.slides) {
      const V u = by_time ? in_all_lanes<V>(link.driven_rate) : y.at(link.at_u);
      to.v = {to.v.x + u * m.s.x, to.v.y + u * m.s.y};
    }
  }
}

// p v q w of the link's body.
template <class S>
template <class V>
ATWOOD_INLINE void PlanarLoops<S>::write_pose(int i, const Work<V>& work, V (&to)[kBodyScalars]) const {
  const auto& link = planar_.links_[i];
  const auto& plane = planar_.planes_[link.plane];
  const Body& body = bodies_[i];
  const LinkPose<V>& pose = work.poses[i];
  const State<V>& m = work.links[i];
  const V rx = m.z.x * link.to_centre.x - m.z.y * link.to_centre.y;
  const V ry = m.z.x * link.to_centre.y + m.z.y * link.to_centre.x;
  const Vec3<V> p = (pose.A.x + rx) * plane.e1 + (pose.A.y + ry) * plane.e2 + body.across * plane.normal;
  const Vec3<V> v = (pose.v.x - m.w * ry) * plane.e1 + (pose.v.y + m.w * rx) * plane.e2;
  V sine, cosine;
  real::same_sin_cos(S(0.5) * pose.angle, sine, cosine);
  const Vec3<V> n = sine * plane.normal;
  const Quat<S>& q = body.attitude;
  const Vec3<V> w = m.w * body.normal_B;
  const V all[kBodyScalars] = {p.x,
                               p.y,
                               p.z,
                               v.x,
                               v.y,
                               v.z,
                               cosine * q.w - n.x * q.x - n.y * q.y - n.z * q.z,
                               cosine * q.x + n.x * q.w + n.y * q.z - n.z * q.y,
                               cosine * q.y - n.x * q.z + n.y * q.w + n.z * q.x,
                               cosine * q.z + n.x * q.y - n.y * q.x + n.z * q.w,
                               w.x,
                               w.y,
                               w.z};
  for (int k = 0; k < kBodyScalars; ++k) to[k] = all[k];
}

template <class S>
template <class V>
ATWOOD_INLINE void PlanarLoops<S>::apply_load(int i, const Vec3<V>& acceleration_W, const Vec3<V>& force_W,
                                              const Vec3<V>& torque_B, Work<V>& work) const {
  const auto& link = planar_.links_[i];
  const auto& plane = planar_.planes_[link.plane];
  State<V>& m = work.links[i];
  const Vec3<V> force = link.mass * acceleration_W + force_W;
  const PairOf<V> f{dot(force, plane.e1), dot(force, plane.e2)};
  const V rx = m.z.x * link.to_centre.x - m.z.y * link.to_centre.y;
  const V ry = m.z.x * link.to_centre.y + m.z.y * link.to_centre.x;
  m.f = {m.f.x - f.x, m.f.y - f.y};
  m.n = m.n - (dot(torque_B, bodies_[i].normal_B) + (rx * f.y - ry * f.x));
}

template <class S>
template <class K, class V>
ATWOOD_INLINE void PlanarLoops<S>::compute_inverse_sqrt_D(K lane, Work<V>& work) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const auto& link = planar_.links_[i];
    if ((link.turns || link.slides) && !link.driven) work.root[link.rate] = root(lane, work.links[i].inverse_D);
  }
}

// As Constraints::whiten; the column is scaled, and its scale returned.
template <class S>
template <class K, class V>
ATWOOD_INLINE V PlanarLoops<S>::whiten(K lane, const Equation& equation, Work<V>& work, V* column) const {
  const Closing& closing = closings_[equation.closing];
  const V zero = in_all_lanes<V>(S(0));
  const Pair& along = equation.direction;
  for (int k = 0; k < rates_; ++k) column[k] = zero;
  for (const int i : closing.path) work.twists[i] = {zero, {zero, zero}};
  V square = zero;
  for (int k = 0; k < 2; ++k) {
    const End& end = closing.end[k];
    if (end.link < 0) continue;
    const S sign = k == 0 ? S(-1) : S(1);
    const PairOf<V> point = arm_of(end, end.point, work), arm = arm_of(end, end.arm, work);
    Twist<V>& p = work.twists[end.link];
    p.n = p.n + sign * (point.x * along.y - point.y * along.x);
    p.f = {p.f.x + sign * along.x, p.f.y + sign * along.y};
    const V moment = arm.x * along.y - arm.y * along.x;
    square = square + (end.inverse_mass + (moment * moment + end.across * end.across) * end.inverse_moment);
  }
  const V scale = S(1) / root(lane, square);
  for (const int i : closing.path) {
    const auto& link = planar_.links_[i];
    const State<V>& m = work.links[i];
    Twist<V>& p = work.twists[i];
    if (link.turns && !link.driven) {
      column[link.rate] = scale * (link.sign * (p.n * work.root[link.rate]));
      const V share = p.n * m.inverse_D;
      p.n = zero;
      p.f = {p.f.x - share * m.h.x, p.f.y - share * m.h.y};
    } else if (link.slides && !link.driven) {
      const V force = m.s.x * p.f.x + m.s.y * p.f.y, share = force * m.inverse_D;
      column[link.rate] = scale * (force * work.root[link.rate]);
      p.n = p.n - share * m.Un;
      p.f = {p.f.x - share * m.Uf.x, p.f.y - share * m.Uf.y};
    }
    if (link.parent < 0) continue;
    Twist<V>& to = work.twists[link.parent];
    to.n = to.n + (p.n + (m.d.x * p.f.y - m.d.y * p.f.x));
    to.f = {to.f.x + p.f.x, to.f.y + p.f.y};
  }
  return scale;
}

// add(link, change of its rate) of W^T z.
template <class S>
template <class V, class F>
ATWOOD_INLINE void PlanarLoops<S>::unwhiten(const V* z, Work<V>& work, const F& add) const {
  const V zero = in_all_lanes<V>(S(0));
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const auto& link = planar_.links_[i];
    const State<V>& m = work.links[i];
    Twist<V>& a = work.twists[i];
    a = {zero, {zero, zero}};
    if (link.parent >= 0) {
      const Twist<V>& parent = work.twists[link.parent];
      a = {parent.n, {parent.f.x - parent.n * m.d.y, parent.f.y + parent.n * m.d.x}};
    }
    if (link.driven) continue;
    if (link.turns) {
      const V angular =
          link.sign * (work.root[link.rate] * z[link.rate]) - m.inverse_D * (m.h.x * a.f.x + m.h.y * a.f.y);
      add(link, link.sign * (angular - a.n));
      a.n = angular;
    } else if (link.slides) {
      const V change =
          work.root[link.rate] * z[link.rate] - m.inverse_D * (m.Un * a.n + (m.Uf.x * a.f.x + m.Uf.y * a.f.y));
      add(link, change);
      a.f = {a.f.x + change * m.s.x, a.f.y + change * m.s.y};
    }
  }
}

// G u' and the motion at constant rates, after PlanarRates::acceleration_pass().
template <class S>
template <class V>
ATWOOD_INLINE V PlanarLoops<S>::acceleration_along(const Equation& equation, const Vec3<S>& gravity_W,
                                                   const Work<V>& work) const {
  const Closing& closing = closings_[equation.closing];
  V sum = in_all_lanes<V>(S(0));
  for (int k = 0; k < 2; ++k) {
    const End& end = closing.end[k];
    PairOf<V> a;
    if (end.link < 0) {  // relative to free fall
      const auto& plane = planar_.planes_[closing.plane];
      a = {in_all_lanes<V>(-dot(gravity_W, plane.e1)), in_all_lanes<V>(-dot(gravity_W, plane.e2))};
    } else {
      const State<V>& m = work.links[end.link];
      const PairOf<V> r = arm_of(end, end.point, work);
      const V square = m.w * m.w;
      a = {m.a.x - m.alpha * r.y - square * r.x, m.a.y + m.alpha * r.x - square * r.y};
    }
    const V part = a.x * equation.direction.x + a.y * equation.direction.y;
    sum = k == 0 ? -part : sum + part;
  }
  return sum;
}

// Householder's reflections of `count` columns of rates_ scalars; returns the least pivot. As LeastNorm without
// exchanges.
template <class S>
template <class K, class V>
ATWOOD_INLINE V PlanarLoops<S>::factor_in_order(K lane, int count, Work<V>& work) const {
  V least = in_all_lanes<V>(S(1));
  for (int k = 0; k < count; ++k) {
    V* v = work.column.data() + k * rates_;
    V square = in_all_lanes<V>(S(0));
    for (int i = k; i < rates_; ++i) square = square + v[i] * v[i];
    const V length = root(lane, square), first = v[k];
    const V pivot = where_above(first, in_all_lanes<V>(S(0)), -length, length);
    work.diagonal[k] = S(1) / pivot;
    v[k] = first - pivot;
    work.reflected[k] = S(1) / (-pivot * v[k]);  // 2 / |v|^2
    least = where_above(least, length, length, least);
    for (int j = k + 1; j < count; ++j) {
      V* c = work.column.data() + j * rates_;
      V sum = v[k] * c[k];
      for (int i = k + 1; i < rates_; ++i) sum = sum + v[i] * c[i];
      sum = sum * work.reflected[k];
      for (int i = k; i < rates_; ++i) c[i] = c[i] - sum * v[i];
    }
  }
  return least;
}

// z = Q (R^-T b, 0)
template <class S>
template <class V>
ATWOOD_INLINE void PlanarLoops<S>::solve_in_order(int count, Work<V>& work) const {
  V* z = work.z.data();
  for (int k = 0; k < count; ++k) {
    const V* c = work.column.data() + k * rates_;
    V left = work.b[k];
    for (int i = 0; i < k; ++i) left = left - c[i] * z[i];
    z[k] = left * work.diagonal[k];
  }
  for (int i = count; i < rates_; ++i) z[i] = in_all_lanes<V>(S(0));
  for (int k = count - 1; k >= 0; --k) {
    const V* v = work.column.data() + k * rates_;
    V sum = v[k] * z[k];
    for (int i = k + 1; i < rates_; ++i) sum = sum + v[i] * z[i];
    sum = sum * work.reflected[k];
    for (int i = k; i < rates_; ++i) z[i] = z[i] - sum * v[i];
  }
}

template <class S>
template <class K, class States, class Applied, class V>
ATWOOD_INLINE V PlanarLoops<S>::constrain(K lane, const States& y, const Vec3<S>& gravity_W, const Applied& applied,
                                          Work<V>& work) const {
  planar_.inward_pass(applied, 0, work.links.data());
  planar_.acceleration_pass(y, gravity_W, work.links.data());
  compute_inverse_sqrt_D(lane, work);
  for (int e = 0; e < chosen_; ++e) {
    const V scale = whiten(lane, equations_[e], work, work.column.data() + e * rates_);
    work.b[e] = -(scale * acceleration_along(equations_[e], gravity_W, work));
  }
  const V least = factor_in_order(lane, chosen_, work);
  solve_in_order(chosen_, work);
  unwhiten(work.z.data(), work, [&](const auto& link, const V& change) ATWOOD_INLINED { y.add(link.at_u, change); });
  return least;
}

}  // namespace atwood
