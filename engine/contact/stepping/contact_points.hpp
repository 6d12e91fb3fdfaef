// Contact points one by one, whichever batch stores them. Sphere contacts are numbered first, then the points of the
// manifolds; the numbers also count lanes and points that are not in use (is_contact).
#pragma once

#include <utility>

#include "contact/stepping/world.hpp"

namespace atwood::stepping {

// Where a contact is stored. point -1: in a sphere batch.
struct ContactAddress {
  int batch = 0, lane = 0, point = -1;
};

template <class S> int point_count(const World<S>& world) {
  return static_cast<int>(world.sphere_contacts.batches.size() * kLaneCount +
                          world.manifold_contacts.batches.size() * 4 * kLaneCount);
}
template <class S> ContactAddress address_of(const World<S>& world, int contact) {
  const int spheres = static_cast<int>(world.sphere_contacts.batches.size()) * kLaneCount;
  if (contact < spheres) return {contact / kLaneCount, contact % kLaneCount, -1};
  const int number = contact - spheres;
  return {number / (4 * kLaneCount), number / 4 % kLaneCount, number % 4};
}
template <class S> SphereBatch<S>& sphere_batch(World<S>& world, const ContactAddress& at) {
  return world.sphere_contacts.batches[static_cast<std::size_t>(at.batch)];
}
template <class S> const SphereBatch<S>& sphere_batch(const World<S>& world, const ContactAddress& at) {
  return world.sphere_contacts.batches[static_cast<std::size_t>(at.batch)];
}
template <class S> ManifoldBatch<S>& manifold_batch(World<S>& world, const ContactAddress& at) {
  return world.manifold_contacts.batches[static_cast<std::size_t>(at.batch)];
}
template <class S> const ManifoldBatch<S>& manifold_batch(const World<S>& world, const ContactAddress& at) {
  return world.manifold_contacts.batches[static_cast<std::size_t>(at.batch)];
}
template <class S> bool is_contact(const World<S>& world, int contact) {
  const ContactAddress at = address_of(world, contact);
  if (at.point < 0) return at.lane < sphere_batch(world, at).count;
  const ManifoldBatch<S>& batch = manifold_batch(world, at);
  return at.lane < batch.count && at.point < batch.points &&
         batch.point[at.point].gap_at_detection.lane[at.lane] < S(kMaxValue);
}
template <class S> std::pair<int, int> bodies_of(const World<S>& world, int contact) {
  const ContactAddress at = address_of(world, contact);
  if (at.point < 0) return {sphere_batch(world, at).a[at.lane], sphere_batch(world, at).b[at.lane]};
  return {manifold_batch(world, at).a[at.lane], manifold_batch(world, at).b[at.lane]};
}

template <class S> Vec3<S> lane_vector(const Lanes<S> (&v)[3], int k) {
  return {v[0].lane[k], v[1].lane[k], v[2].lane[k]};
}
template <class S> void set_lane_vector(const Vec3<S>& v, int k, Lanes<S> (&to)[3]) {
  to[0].lane[k] = v.x;
  to[1].lane[k] = v.y;
  to[2].lane[k] = v.z;
}

// A unit vector across n: n x e, normalised, with e the world's axis that is farthest from n's direction.
template <class S> Vec3<S> unit_tangent(const Vec3<S>& n) {
  const S x = real::abs(n.x), y = real::abs(n.y), z = real::abs(n.z);
  const Vec3<S> axis = x <= y && x <= z ? Vec3<S>{S(1), S(0), S(0)}
                       : y <= z         ? Vec3<S>{S(0), S(1), S(0)}
                                        : Vec3<S>{S(0), S(0), S(1)};
  const Vec3<S> across = cross(n, axis);
  return (S(1) / norm(across)) * across;
}

template <class T> struct AdvancedPoint {
  Vec3<T> arm_a, arm_b;  // from the centres of mass to the contact point
  T gap;                 // along the manifold's normal
};
// The contact point of a manifold when the centre of mass of b is at d from that of a and the bodies have rotated by
// the rotation vectors s_a and s_b since detection, to first order in s. The normal stays that of detection.
//
// A corner rotates with its body, but the contact point of a sphere does not: a material point at rate w leaves the
// line from the centre by w h r within h, and with that arm the normal force would brake the sphere. So of a capsule
// the point of its axis rotates, and of a cylinder only the part of the rotation across its axis counts.
// `witness_offset` places the contact point between the two surface points: 1/2 on b's, -1/2 on a's, 0 midway.
template <class S, class T>
ATWOOD_INLINE AdvancedPoint<T> advance_point(const Vec3<T>& n, const Vec3<T>& r_a, const Vec3<T>& r_b,
                                             const T& gap_at_detection, const Vec3<T>& d, const Vec3<T>& s_a,
                                             const Vec3<T>& s_b, const Rounding<T>& a, const Rounding<T>& b,
                                             const T& witness_offset) {
  const Vec3<T> x_a = r_a + cross(s_a - dot(s_a, a.axis) * a.axis, r_a - a.radius_m * n);
  const Vec3<T> x_b = r_b + cross(s_b - dot(s_b, b.axis) * b.axis, r_b + b.radius_m * n);
  const Vec3<T> between = d + (x_b - x_a);
  const T along = dot(n, between);
  const Vec3<T> aside = witness_offset * (between - along * n);
  return {x_a + S(0.5) * between + aside, x_b - S(0.5) * between + aside, gap_at_detection + along};
}

// One contact point as the direct solver and the reports see it, as the last substep prepared it.
template <class S> struct SolverPoint {
  int a = 0, b = 0;               // bodies
  Vec3<S> n, t, s, arm_a, arm_b;  // frame (n from a to b), arms from the centres of mass
  S gap{}, bias{}, friction{}, restitution{};
  S impulse[3] = {};           // N s on b, along n, t and s
  S surface_velocity[2] = {};  // m/s, along t and s (rolling.cpp)
};

template <class S> SolverPoint<S> solver_point(const World<S>& world, int contact) {
  SolverPoint<S> out;
  const ContactAddress at = address_of(world, contact);
  const int k = at.lane;
  if (at.point < 0) {
    const SphereBatch<S>& batch = sphere_batch(world, at);
    const Vec3<S> n = lane_vector(batch.normal, k), t = unit_tangent(n), s = cross(n, t),
                  P = lane_vector(batch.impulse_t, k);
    out = {batch.a[k],
           batch.b[k],
           n,
           t,
           s,
           batch.arm_a.lane[k] * n,
           -batch.arm_b.lane[k] * n,
           batch.gap.lane[k],
           batch.bias.lane[k],
           batch.friction.lane[k],
           batch.restitution.lane[k],
           {batch.impulse_n.lane[k], dot(P, t), dot(P, s)}};
    return out;
  }
  const ManifoldBatch<S>& batch = manifold_batch(world, at);
  const ManifoldPoint<S>& point = batch.point[at.point];
  const Vec3<S> n = lane_vector(batch.normal, k), t = lane_vector(batch.tangent, k);
  out = {batch.a[k],
         batch.b[k],
         n,
         t,
         cross(n, t),
         lane_vector(point.arm_a, k),
         lane_vector(point.arm_b, k),
         point.gap.lane[k],
         point.bias.lane[k],
         batch.friction.lane[k],
         batch.restitution.lane[k],
         {point.impulse_n.lane[k], point.impulse_t[0].lane[k], point.impulse_t[1].lane[k]}};
  if (batch.has_surface_velocity) {
    out.surface_velocity[0] = batch.surface_velocity[at.point][0].lane[k];
    out.surface_velocity[1] = batch.surface_velocity[at.point][1].lane[k];
  }
  return out;
}

// Writes the impulses of `from` back to the contact's batch.
template <class S> void store_impulse(World<S>& world, int contact, const SolverPoint<S>& from) {
  const ContactAddress at = address_of(world, contact);
  const int k = at.lane;
  if (at.point < 0) {
    SphereBatch<S>& batch = sphere_batch(world, at);
    batch.impulse_n.lane[k] = from.impulse[0];
    set_lane_vector(from.impulse[1] * from.t + from.impulse[2] * from.s, k, batch.impulse_t);
    return;
  }
  ManifoldPoint<S>& point = manifold_batch(world, at).point[at.point];
  point.impulse_n.lane[k] = from.impulse[0];
  point.impulse_t[0].lane[k] = from.impulse[1];
  point.impulse_t[1].lane[k] = from.impulse[2];
}

// I^-1 L, of an inertia row and an angular impulse in world axes.
template <class S> Vec3<S> apply_inverse_inertia(const Row<S>& inertia, const Vec3<S>& L) {
  const S* I = inertia.at;
  return {I[0] * L.x + I[1] * L.y + I[2] * L.z, I[1] * L.x + I[3] * L.y + I[4] * L.z,
          I[2] * L.x + I[4] * L.y + I[5] * L.z};
}
// Velocity of b less that of a at the contact point, m/s.
template <class S> Vec3<S> relative_velocity(const BodyRows<S>& bodies, const SolverPoint<S>& point) {
  const S *a = bodies.velocity[point.a].at, *b = bodies.velocity[point.b].at;
  return (load3(b) + cross(load3(b + 3), point.arm_b)) - (load3(a) + cross(load3(a + 3), point.arm_a));
}

}  // namespace atwood::stepping
