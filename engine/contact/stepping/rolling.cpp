// Cylinders and capsules that roll or spin on what they touch, to second order in the substep.
//
// A lasting contact keeps J v = 0, and J changes as the contact point moves along the rim. If the impulses along J^T
// make J v = 0 with the same J in each substep, they project v and remove |(1 - P') v|^2 each time: a loss of first
// order, h Omega^2 of the energy in a second for a coin whose contact point circulates at rate Omega. Leapfrog avoids
// it: with velocities at half substeps, v_- at n - 1/2 and v_+ at n + 1/2,
//   M (v_+ - v_-) = h f(q_n) + J(q_n)^T lambda,     J(q_n+1/2) v_+ = 0
// and the contact forces do the work lambda . J(q_n) (v_- + v_+) / 2 = O(h^3) in a substep. So, for bodies that roll:
// - contacts are detected at the beginning of every substep, and impulses act there;
// - the constraint is imposed at the point that touches half a substep later. Its motion relative to the body is known
//   in advance, and enters as a velocity of the surface (`bias` and `surface_velocity`);
// - Euler's equations of the free top are stepped in each substep about its middle: half of the last substep's change
//   of the body rate by contacts is added before and removed after;
// - rotations are composed, not added.
// Where positions go by the mean of two velocities all of it lies half a substep later.
#include "contact/stepping/contact_points.hpp"
#include "contact/stepping/mechanisms.hpp"
#include "math/so3.hpp"
#include "rigid/free_top.hpp"

namespace atwood::stepping {
namespace {

// A contact point that moves farther around the rim than this in a substep is not predicted.
constexpr double kMaxRimAngle_rad = 0.5;

bool is_round(ShapeKind kind) { return kind == ShapeKind::cylinder || kind == ShapeKind::capsule; }

// Whether one of its points carries an impulse, or touches.
template <class S> bool is_loaded(const World<S>& world, const ContactManifold<S>& manifold) {
  const ManifoldBatch<S>& batch = world.manifold_contacts.batches[static_cast<std::size_t>(manifold.slot / kLaneCount)];
  const int k = manifold.slot % kLaneCount;
  for (int i = 0; i < manifold.geometry.count; ++i)
    if (batch.point[i].impulse_n.lane[k] > S(0) || manifold.geometry.points[i].gap <= batch.slop.lane[k]) return true;
  return false;
}

template <class S> Vec3<S> axis_of(const World<S>& world, int body) {
  const Quat<S> q = so3_exp(load3(world.bodies.pose[body].at + 3)) * world.bodies.q_WB[body];
  return rotate(q, Vec3<S>{S(0), S(0), S(1)});
}

// Velocity, relative to the body's centre of mass, of the contact point at r with the outward unit normal m, while the
// body rotates at rate w and m is constant. On a capsule the point moves with the centre of its cap. On a cylinder's
// rim, r = z a + R d with the axis a, d the unit vector across it that is nearest to m, a' = w x a and e = a x d:
//   d' = -(a' . d) a - (m . a / m . d) (a' . e) e
// Any other point of a cylinder moves with the material.
template <class S>
Vec3<S> contact_point_velocity(const World<S>& world, int body, const Vec3<S>& r, const Vec3<S>& m, const Vec3<S>& w) {
  const Geometry<S>& shape = world.geometry[body];
  if (shape.kind == ShapeKind::capsule) return cross(w, r - shape.radius * m);
  if (shape.kind != ShapeKind::cylinder) return cross(w, r);
  const Vec3<S> a = axis_of(world, body), across = m - dot(m, a) * a;
  const S m_d = norm(across), z = dot(r, a);
  if (!(m_d > S(0))) return cross(w, r);
  const Vec3<S> d = (S(1) / m_d) * across, off_rim = (r - z * a) - shape.radius * d;
  if (dot(off_rim, off_rim) > S(1e-4) * shape.radius * shape.radius) return cross(w, r);
  const Vec3<S> turn = cross(w, a), e = cross(a, d);
  const S around = -(dot(m, a) / m_d) * dot(turn, e);
  if (real::abs(around) * world.sub_s > S(kMaxRimAngle_rad)) return cross(w, r);
  return z * turn + shape.radius * (around * e - dot(turn, d) * a);
}

// Change of the angular velocity, in world axes, of the free top over direct_s + adjoint_s (the scheme's two halves,
// free_turn()). `middle`: q is the orientation in the middle, and the change is rotated by it; else q is that at the
// beginning, and the change is the difference of the angular velocities at the end and at the beginning.
template <class S>
Vec3<S> gyroscopic_change(const World<S>& world, int body, const Quat<S>& q, const Vec3<S>& w_W, S direct_s,
                          S adjoint_s, bool middle) {
  FreeTurn<S> turn;
  const Vec3<S> w_B = rotate_back(q, w_W);
  free_turn(FreeTop::splitting, world.model->mass(body), direct_s, adjoint_s, w_B, turn);
  if (middle) return rotate(q, turn.dw_B);
  const Quat<S> by = q * turn.minus_one;
  return rotate(normalised(Quat<S>{q.w + by.w, q.x + by.x, q.y + by.y, q.z + by.z}), w_B + turn.dw_B) - w_W;
}

// Changes the angular velocity by I^-1 L.
template <class S> void apply_angular_impulse(World<S>& world, int body, const Vec3<S>& L) {
  S* w = world.bodies.velocity[body].at + 3;
  if (world.bodies.moves[body]) store3(load3(w) + apply_inverse_inertia(world.bodies.inertia[body], L), w);
}

// Adds a body to those that roll in this step of h_s, and sets what forces do to its body rate in a substep. Removes
// from its increments what they contain of the free top, which set_rolling_velocity_increments() steps anew.
template <class S> void begin_rolling(World<S>& world, int body, S h_s) {
  BodyRows<S>& bodies = world.bodies;
  Rolling<S>& rolling = world.rolling;
  if (rolling.rolls[body] == 0) rolling.acceleration_by_contacts[body] = {};
  rolling.rolls[body] = 2;
  rolling.bodies.push_back(body);
  rolling.rate_change_by_forces[body] = load3(bodies.velocity_increment[body].at + 3);
  if (bodies.isotropic[body]) return;
  // step.cpp put the free top of the whole step into the increments
  const bool fused = world.stepper == nullptr;
  const Vec3<S> w_W = load3(bodies.velocity[body].at + 3);
  const Vec3<S> whole = gyroscopic_change(world, body, bodies.q_WB[body], w_W, fused ? h_s : h_s / S(2),
                                          fused ? S(0) : h_s / S(2), false);
  rolling.rate_change_by_forces[body] -= (S(1) / S(world.substeps)) * whole;
  store3(Vec3<S>{}, bodies.pose_increment[body].at + 3);
}

}  // namespace

template <class S> void list_rolling(World<S>& world, S h_s) {
  Rolling<S>& rolling = world.rolling;
  if (!rolling.has_round_bodies) return;
  rolling.bodies.clear();
  rolling.manifolds.clear();
  for (std::size_t i = 0; i < world.manifolds.size(); ++i) {
    const ContactManifold<S>& manifold = world.manifolds[i];
    const auto rolls = [&](int body) {
      return world.bodies.moves[body] && world.model->rotates(body) && is_round(world.geometry[body].kind) &&
             !is_tied(world, body);
    };
    if (!(rolls(manifold.a) || rolls(manifold.b)) || !is_loaded(world, manifold)) continue;
    rolling.manifolds.push_back(static_cast<int>(i));
    for (const int body : {manifold.a, manifold.b})
      if (rolls(body) && rolling.rolls[body] != 2) begin_rolling(world, body, h_s);
  }
  for (unsigned char& rolls : rolling.rolls) rolls = rolls == 2 ? 1 : 0;
}

template <class S> void update_rolling_inertias(World<S>& world) {
  BodyRows<S>& bodies = world.bodies;
  for (const int i : world.rolling.bodies)
    if (!bodies.isotropic[i])
      bodies.inertia[i] = inverse_inertia(world.model->mass(i), so3_exp(load3(bodies.pose[i].at + 3)) * bodies.q_WB[i]);
}

template <class S> void set_rolling_velocity_increments(World<S>& world) {
  BodyRows<S>& bodies = world.bodies;
  Rolling<S>& rolling = world.rolling;
  for (const int i : rolling.bodies) {
    const Vec3<S> w = load3(bodies.velocity[i].at + 3);
    Vec3<S> change = rolling.rate_change_by_forces[i];
    if (!bodies.isotropic[i]) {
      Quat<S> q = so3_exp(load3(bodies.pose[i].at + 3)) * bodies.q_WB[i];
      if (world.positions_by_mean_velocity) {
        q = so3_exp((world.sub_s / S(2)) * w) * q;
        bodies.inertia[i] = inverse_inertia(world.model->mass(i), q);
      }
      Vec3<S> half = S(0.5) * (rolling.rate_change_by_forces[i] + world.sub_s * rolling.acceleration_by_contacts[i]);
      if (dot(half, half) > S(0.0625) * dot(w, w))
        half = {};  // an impact: the last substep says nothing about this one
      change += gyroscopic_change(world, i, q, w + half, world.sub_s / S(2), world.sub_s / S(2), true);
    }
    store3(change, bodies.velocity_increment[i].at + 3);
    rolling.rate_after_forces[i] = w + change;
    rolling.rotation_before_drift[i] = load3(bodies.pose[i].at + 3);
  }
}

// The velocities contain the warm start's impulses.
template <class S> void predict_rolling_contact_points(World<S>& world) {
  BodyRows<S>& bodies = world.bodies;
  for (const int index : world.rolling.manifolds) {
    const ContactManifold<S>& manifold = world.manifolds[static_cast<std::size_t>(index)];
    ManifoldBatch<S>& batch = world.manifold_contacts.batches[static_cast<std::size_t>(manifold.slot / kLaneCount)];
    const int k = manifold.slot % kLaneCount;
    batch.has_surface_velocity = true;
    const Vec3<S> n = lane_vector(batch.normal, k), t = lane_vector(batch.tangent, k);
    for (int i = 0; i < manifold.geometry.count; ++i) {
      ManifoldPoint<S>& point = batch.point[i];
      Vec3<S> r_a = lane_vector(point.arm_a, k), r_b = lane_vector(point.arm_b, k);
      const S half_gap = point.gap.lane[k] / S(2);
      const auto ahead = [&](int body, const Vec3<S>& r, const Vec3<S>& m) {
        if (!bodies.moves[body] || !is_round(world.geometry[body].kind) || is_tied(world, body)) return Vec3<S>{};
        return (world.sub_s / S(2)) *
               contact_point_velocity(world, body, r - half_gap * m, m, load3(bodies.velocity[body].at + 3));
      };
      const Vec3<S> d_a = ahead(manifold.a, r_a, n), d_b = ahead(manifold.b, r_b, -n);
      if (world.positions_by_mean_velocity) {  // the impulse acts at the predicted point; that of the warm start too
        const Vec3<S> P =
            point.impulse_n.lane[k] * n + point.impulse_t[0].lane[k] * t + point.impulse_t[1].lane[k] * cross(n, t);
        apply_angular_impulse(world, manifold.a, cross(d_a, -P));
        apply_angular_impulse(world, manifold.b, cross(d_b, P));
        set_lane_vector(r_a + d_a, k, point.arm_a);
        set_lane_vector(r_b + d_b, k, point.arm_b);
      }
      const Vec3<S> u =
          cross(load3(bodies.velocity[manifold.b].at + 3), d_b) - cross(load3(bodies.velocity[manifold.a].at + 3), d_a);
      point.bias.lane[k] += dot(u, n);
      batch.surface_velocity[i][0].lane[k] = dot(u, t);
      batch.surface_velocity[i][1].lane[k] = dot(u, cross(n, t));
    }
  }
}

template <class S> void compose_rolling_rotations(World<S>& world) {
  BodyRows<S>& bodies = world.bodies;
  Rolling<S>& rolling = world.rolling;
  for (const int i : rolling.bodies) {
    rolling.acceleration_by_contacts[i] =
        (S(1) / world.sub_s) * (load3(bodies.velocity[i].at + 3) - rolling.rate_after_forces[i]);
    const Vec3<S> by = load3(bodies.pose[i].at + 3) - rolling.rotation_before_drift[i];
    store3(so3_log(so3_exp(by) * so3_exp(rolling.rotation_before_drift[i])), bodies.pose[i].at + 3);
  }
}

#define ATWOOD_ROLLING(S)                                      \
  template void list_rolling<S>(World<S>&, S);                 \
  template void update_rolling_inertias<S>(World<S>&);         \
  template void set_rolling_velocity_increments<S>(World<S>&); \
  template void predict_rolling_contact_points<S>(World<S>&);  \
  template void compose_rolling_rotations<S>(World<S>&);
ATWOOD_ROLLING(float)
ATWOOD_ROLLING(double)
#undef ATWOOD_ROLLING

}  // namespace atwood::stepping
