// Contact points one by one, whatever batch they stand in: balls first, then the manifolds' points.
#pragma once

#include <utility>

#include "contact/stepping/world.hpp"

namespace atwood::stepping {

// Point -1: a contact of balls
struct Place {
  int batch = 0, lane = 0, point = -1;
};

// Lanes without a contact are numbered too; see `used`.
template <class S> int point_count(const World<S>& world) {
  return static_cast<int>(world.balls.batches.size() * kLaneCount +
                          world.manifold_batches.batches.size() * 4 * kLaneCount);
}
template <class S> Place place_of(const World<S>& world, int contact) {
  const int balls = static_cast<int>(world.balls.batches.size()) * kLaneCount;
  if (contact < balls) return {contact / kLaneCount, contact % kLaneCount, -1};
  const int rest = contact - balls;
  return {rest / (4 * kLaneCount), rest / 4 % kLaneCount, rest % 4};
}
template <class S> BallBatch<S>& balls_at(World<S>& world, const Place& at) {
  return world.balls.batches[static_cast<std::size_t>(at.batch)];
}
template <class S> const BallBatch<S>& balls_at(const World<S>& world, const Place& at) {
  return world.balls.batches[static_cast<std::size_t>(at.batch)];
}
template <class S> ManifoldBatch<S>& manifolds_at(World<S>& world, const Place& at) {
  return world.manifold_batches.batches[static_cast<std::size_t>(at.batch)];
}
template <class S> const ManifoldBatch<S>& manifolds_at(const World<S>& world, const Place& at) {
  return world.manifold_batches.batches[static_cast<std::size_t>(at.batch)];
}
template <class S> bool used(const World<S>& world, int contact) {
  const Place at = place_of(world, contact);
  if (at.point < 0) return at.lane < balls_at(world, at).count;
  const ManifoldBatch<S>& batch = manifolds_at(world, at);
  return at.lane < batch.count && at.point < batch.points && batch.point[at.point].gap_found.lane[at.lane] < S(1e29);
}
template <class S> std::pair<int, int> bodies_of(const World<S>& world, int contact) {
  const Place at = place_of(world, contact);
  if (at.point < 0) return {balls_at(world, at).a[at.lane], balls_at(world, at).b[at.lane]};
  return {manifolds_at(world, at).a[at.lane], manifolds_at(world, at).b[at.lane]};
}

template <class S> Vec3<S> lane_of(const Lanes<S> (&v)[3], int k) { return {v[0].lane[k], v[1].lane[k], v[2].lane[k]}; }
template <class S> void put_lane(const Vec3<S>& v, int k, Lanes<S> (&to)[3]) {
  to[0].lane[k] = v.x;
  to[1].lane[k] = v.y;
  to[2].lane[k] = v.z;
}

// Across n, along the axis of the world that n is least along.
template <class S> Vec3<S> tangent_of(const Vec3<S>& n) {
  const S x = real::abs(n.x), y = real::abs(n.y), z = real::abs(n.z);
  const Vec3<S> axis = x <= y && x <= z ? Vec3<S>{S(1), S(0), S(0)}
                       : y <= z         ? Vec3<S>{S(0), S(1), S(0)}
                                        : Vec3<S>{S(0), S(0), S(1)};
  const Vec3<S> across = cross(n, axis);
  return (S(1) / norm(across)) * across;
}

// Where a manifold's point is after the bodies have moved by d (b less a) and turned by s since it was found, first
// order.
//
// A corner goes with its body, but what touches of a ball does not turn with it: at speed w the material point leaves
// the line from the centre by w h r, and the normal force would brake the ball on that arm. Of a capsule the point of
// its axis turns, of a cylinder what is not along its axis. `lean`: 1/2 where b's surface says what touches, -1/2 where
// a's, 0 midway.
template <class T> struct MovedPoint {
  Vec3<T> arm_a, arm_b;
  T gap;
};
template <class S, class T>
ATWOOD_INLINE MovedPoint<T> moved_point(const Vec3<T>& n, const Vec3<T>& r_a, const Vec3<T>& r_b, const T& gap_found,
                                        const Vec3<T>& d, const Vec3<T>& s_a, const Vec3<T>& s_b, const Outline<T>& a,
                                        const Outline<T>& b, const T& lean) {
  const Vec3<T> x_a = r_a + cross(s_a - dot(s_a, a.axis) * a.axis, r_a - a.round_m * n);
  const Vec3<T> x_b = r_b + cross(s_b - dot(s_b, b.axis) * b.axis, r_b + b.round_m * n);
  const Vec3<T> between = d + (x_b - x_a);
  const T along = dot(n, between);
  const Vec3<T> aside = lean * (between - along * n);
  return {x_a + S(0.5) * between + aside, x_b - S(0.5) * between + aside, gap_found + along};
}

// As a substep has prepared it. The impulse is on b, in the frame n, t, n x t.
template <class S> struct Point {
  int a = 0, b = 0;
  Vec3<S> n, t, s, arm_a, arm_b;
  S gap{}, closing{}, friction{}, restitution{};
  S impulse[3] = {};
  S slip[2] = {};  // of the point ahead, along t and s
};

template <class S> Point<S> point_at(const World<S>& world, int contact) {
  Point<S> out;
  const Place at = place_of(world, contact);
  const int k = at.lane;
  if (at.point < 0) {
    const BallBatch<S>& batch = balls_at(world, at);
    const Vec3<S> n = lane_of(batch.normal, k), t = tangent_of(n), s = cross(n, t), P = lane_of(batch.impulse_t, k);
    out = {batch.a[k],
           batch.b[k],
           n,
           t,
           s,
           batch.arm_a.lane[k] * n,
           -batch.arm_b.lane[k] * n,
           batch.gap.lane[k],
           batch.closing.lane[k],
           batch.friction.lane[k],
           batch.restitution.lane[k],
           {batch.impulse_n.lane[k], dot(P, t), dot(P, s)}};
    return out;
  }
  const ManifoldBatch<S>& batch = manifolds_at(world, at);
  const ManifoldPoint<S>& point = batch.point[at.point];
  const Vec3<S> n = lane_of(batch.normal, k), t = lane_of(batch.tangent, k);
  out = {batch.a[k],
         batch.b[k],
         n,
         t,
         cross(n, t),
         lane_of(point.arm_a, k),
         lane_of(point.arm_b, k),
         point.gap.lane[k],
         point.closing.lane[k],
         batch.friction.lane[k],
         batch.restitution.lane[k],
         {point.impulse_n.lane[k], point.impulse_t[0].lane[k], point.impulse_t[1].lane[k]}};
  if (batch.slips) {
    out.slip[0] = batch.slip[at.point][0].lane[k];
    out.slip[1] = batch.slip[at.point][1].lane[k];
  }
  return out;
}

template <class S> void put_impulse(World<S>& world, int contact, const Point<S>& from) {
  const Place at = place_of(world, contact);
  const int k = at.lane;
  if (at.point < 0) {
    BallBatch<S>& batch = balls_at(world, at);
    batch.impulse_n.lane[k] = from.impulse[0];
    put_lane(from.impulse[1] * from.t + from.impulse[2] * from.s, k, batch.impulse_t);
    return;
  }
  ManifoldPoint<S>& point = manifolds_at(world, at).point[at.point];
  point.impulse_n.lane[k] = from.impulse[0];
  point.impulse_t[0].lane[k] = from.impulse[1];
  point.impulse_t[1].lane[k] = from.impulse[2];
}

// I^-1 L in world axes.
template <class S> Vec3<S> turned_by(const Row<S>& inertia, const Vec3<S>& L) {
  const S* I = inertia.at;
  return {I[0] * L.x + I[1] * L.y + I[2] * L.z, I[1] * L.x + I[3] * L.y + I[4] * L.z,
          I[2] * L.x + I[4] * L.y + I[5] * L.z};
}
// Relative velocity at the point.
template <class S> Vec3<S> velocity_at(const Bodies<S>& bodies, const Point<S>& point) {
  const S *a = bodies.velocity[point.a].at, *b = bodies.velocity[point.b].at;
  return (load3(b) + cross(load3(b + 3), point.arm_b)) - (load3(a) + cross(load3(a + 3), point.arm_a));
}

}  // namespace atwood::stepping
