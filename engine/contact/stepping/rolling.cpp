// Cylinders and capsules that roll or spin on what they touch, to second order in the substep.
//
// A contact that lasts keeps J v = 0, and J changes as the point of contact runs along the rim. Impulses along J^T that
// make J v = 0 with the same J, substep after substep, project v, and take |(1 - P') v|^2 of it each time: a loss of
// first order, h Omega^2 of the energy in a second for a coin whose point of contact goes round at Omega. Leapfrog does
// not take it: with velocities at half substeps, v_- at n - 1/2 and v_+ at n + 1/2,
//   M (v_+ - v_-) = h f(q_n) + J(q_n)^T lambda,     J(q_n+1/2) v_+ = 0
// and friction and pressure do work lambda . J(q_n) (v_- + v_+) / 2 = O(h^3) a substep. So, of bodies that roll,
// - contacts are found at the beginning of every substep, and there impulses act;
// - what is asked of velocities there is asked of the point that touches half a substep later: its motion over the body
//   is known ahead, and enters as a velocity of the surface (`closing` and `slip`);
// - Euler's equations for the free top are stepped in each substep about its middle, with half of what the contacts did
//   to the body rate in the last one added before and taken away after (kick, turn, kick);
// - turns are composed, not added.
// Where places go by the mean of two velocities all of it lies half a substep later.
#include "contact/stepping/points.hpp"
#include "math/so3.hpp"
#include "rigid/free_top.hpp"

namespace atwood::stepping {
namespace {

// A point of contact that goes farther around the rim than this in a substep is not followed.
constexpr double kMostTurn_rad = 0.5;

bool is_round(ShapeKind kind) { return kind == ShapeKind::cylinder || kind == ShapeKind::capsule; }

// Whether one of its points carries, or is about to.
template <class S> bool carries(const World<S>& world, const FoundManifold<S>& found) {
  const ManifoldBatch<S>& batch = world.manifold_batches.batches[static_cast<std::size_t>(found.slot / kLaneCount)];
  const int k = found.slot % kLaneCount;
  for (int i = 0; i < found.shape.count; ++i)
    if (batch.point[i].impulse_n.lane[k] > S(0) || found.shape.points[i].gap <= batch.slop.lane[k]) return true;
  return false;
}

template <class S> Vec3<S> axis_of(const World<S>& world, int body) {
  const Quat<S> q = so3_exp(load3(world.bodies.place[body].at + 3)) * world.bodies.q_WB[body];
  return rotate(q, Vec3<S>{S(0), S(0), S(1)});
}

// How fast the point at r that touches along m (unit, outward) moves against the body's centre while the body turns at
// w, m as it is. Of a capsule it is the centre of the cap that turns. On a cylinder's rim, r = z a + R d with d the
// unit vector across the axis that is nearest to m, a' = w x a and e = a x d:
//   d' = -(a' . d) a - (m . a / m . d) (a' . e) e
// Any other point of a cylinder goes with it.
template <class S>
Vec3<S> touching_velocity(const World<S>& world, int body, const Vec3<S>& r, const Vec3<S>& m, const Vec3<S>& w) {
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
  if (real::abs(around) * world.sub_s > S(kMostTurn_rad)) return cross(w, r);
  return z * turn + shape.radius * (around * e - dot(turn, d) * a);
}

// By the free top alone, over h: the change of the body rate in world axes. Seen from the attitude q in the middle; or,
// where places go by the mean, from q before and from where the turn leads after.
template <class S>
Vec3<S> gyroscopic_change(const World<S>& world, int body, const Quat<S>& q, const Vec3<S>& w_W, S direct_s,
                          S adjoint_s, bool middle) {
  FreeTurn<S> turn;
  const Vec3<S> w_B = rotate_back(q, w_W);
  free_turn(FreeTop::splitting, world.model->mass(body), direct_s, adjoint_s, w_B, turn);
  if (middle) return rotate(q, turn.dw_B);
  const Quat<S> by = q * turn.less_one;
  return rotate(normalised(Quat<S>{q.w + by.w, q.x + by.x, q.y + by.y, q.z + by.z}), w_B + turn.dw_B) - w_W;
}

template <class S> void turn_by(World<S>& world, int body, const Vec3<S>& L) {
  S* w = world.bodies.velocity[body].at + 3;
  if (world.bodies.moves[body]) store3(load3(w) + turned_by(world.bodies.inertia[body], L), w);
}

template <class S> void begin_rolling(World<S>& world, int body, S h_s) {
  Bodies<S>& bodies = world.bodies;
  Rolling<S>& rolling = world.rolling;
  if (rolling.rolls[body] == 0) rolling.by_contacts[body] = {};
  rolling.rolls[body] = 2;
  rolling.bodies.push_back(body);
  rolling.by_forces[body] = load3(bodies.kick[body].at + 3);
  if (bodies.isotropic[body]) return;
  // What the step's kick holds of the free top is taken out of it: step.cpp and prepare_flight() put it in.
  const bool fused = world.stepper == nullptr;
  const Vec3<S> w_W = load3(bodies.velocity[body].at + 3);
  const Vec3<S> whole = gyroscopic_change(world, body, bodies.q_WB[body], w_W, fused ? h_s : h_s / S(2),
                                          fused ? S(0) : h_s / S(2), false);
  rolling.by_forces[body] -= (S(1) / S(world.substeps)) * whole;
  store3(Vec3<S>{}, bodies.rest[body].at + 3);
}

}  // namespace

template <class S> void list_rolling(World<S>& world, S h_s) {
  Rolling<S>& rolling = world.rolling;
  if (!rolling.some_round) return;
  rolling.bodies.clear();
  rolling.manifolds.clear();
  for (std::size_t i = 0; i < world.manifolds.size(); ++i) {
    const FoundManifold<S>& found = world.manifolds[i];
    const auto rolls = [&](int body) {
      return world.bodies.moves[body] && world.model->rotates(body) && is_round(world.geometry[body].kind);
    };
    if (!(rolls(found.a) || rolls(found.b)) || !carries(world, found)) continue;
    rolling.manifolds.push_back(static_cast<int>(i));
    for (const int body : {found.a, found.b})
      if (rolls(body) && rolling.rolls[body] != 2) begin_rolling(world, body, h_s);
  }
  for (unsigned char& rolls : rolling.rolls) rolls = rolls == 2 ? 1 : 0;
}

// Before contacts are found anew in a later substep.
template <class S> void turn_rolling_inertias(World<S>& world) {
  Bodies<S>& bodies = world.bodies;
  for (const int i : world.rolling.bodies)
    if (!bodies.isotropic[i])
      bodies.inertia[i] =
          inverse_inertia(world.model->mass(i), so3_exp(load3(bodies.place[i].at + 3)) * bodies.q_WB[i]);
}

template <class S> void kick_rolling(World<S>& world, S sub_s) {
  Bodies<S>& bodies = world.bodies;
  Rolling<S>& rolling = world.rolling;
  for (const int i : rolling.bodies) {
    const Vec3<S> w = load3(bodies.velocity[i].at + 3);
    Vec3<S> change = rolling.by_forces[i];
    if (!bodies.isotropic[i]) {
      Quat<S> q = so3_exp(load3(bodies.place[i].at + 3)) * bodies.q_WB[i];
      if (world.by_mean) {
        q = so3_exp((sub_s / S(2)) * w) * q;
        bodies.inertia[i] = inverse_inertia(world.model->mass(i), q);
      }
      Vec3<S> half = S(0.5) * (rolling.by_forces[i] + sub_s * rolling.by_contacts[i]);
      if (dot(half, half) > S(0.0625) * dot(w, w)) half = {};  // an impact: nothing to go by
      change += gyroscopic_change(world, i, q, w + half, sub_s / S(2), sub_s / S(2), true);
    }
    store3(change, bodies.kick[i].at + 3);
    rolling.kicked[i] = w + change;
    rolling.turned[i] = load3(bodies.place[i].at + 3);
  }
}

// After the contacts are prepared: velocities hold what the last substep's impulses make of them.
template <class S> void look_ahead(World<S>& world, S sub_s) {
  Bodies<S>& bodies = world.bodies;
  for (const int index : world.rolling.manifolds) {
    const FoundManifold<S>& found = world.manifolds[static_cast<std::size_t>(index)];
    ManifoldBatch<S>& batch = world.manifold_batches.batches[static_cast<std::size_t>(found.slot / kLaneCount)];
    const int k = found.slot % kLaneCount;
    batch.slips = true;
    const Vec3<S> n = lane_of(batch.normal, k), t = lane_of(batch.tangent, k);
    for (int i = 0; i < found.shape.count; ++i) {
      ManifoldPoint<S>& point = batch.point[i];
      Vec3<S> r_a = lane_of(point.arm_a, k), r_b = lane_of(point.arm_b, k);
      const S half_gap = point.gap.lane[k] / S(2);
      const auto ahead = [&](int body, const Vec3<S>& r, const Vec3<S>& m) {
        if (!bodies.moves[body] || !is_round(world.geometry[body].kind)) return Vec3<S>{};
        return (sub_s / S(2)) *
               touching_velocity(world, body, r - half_gap * m, m, load3(bodies.velocity[body].at + 3));
      };
      const Vec3<S> d_a = ahead(found.a, r_a, n), d_b = ahead(found.b, r_b, -n);
      if (world.by_mean) {  // there its impulse acts, what it has been given of it included
        const Vec3<S> P =
            point.impulse_n.lane[k] * n + point.impulse_t[0].lane[k] * t + point.impulse_t[1].lane[k] * cross(n, t);
        turn_by(world, found.a, cross(d_a, -P));
        turn_by(world, found.b, cross(d_b, P));
        put_lane(r_a + d_a, k, point.arm_a);
        put_lane(r_b + d_b, k, point.arm_b);
      }
      const Vec3<S> u =
          cross(load3(bodies.velocity[found.b].at + 3), d_b) - cross(load3(bodies.velocity[found.a].at + 3), d_a);
      point.closing.lane[k] += dot(u, n);
      batch.slip[i][0].lane[k] = dot(u, t);
      batch.slip[i][1].lane[k] = dot(u, cross(n, t));
    }
  }
}

// After the drift.
template <class S> void turn_rolling(World<S>& world, S sub_s) {
  Bodies<S>& bodies = world.bodies;
  Rolling<S>& rolling = world.rolling;
  for (const int i : rolling.bodies) {
    rolling.by_contacts[i] = (S(1) / sub_s) * (load3(bodies.velocity[i].at + 3) - rolling.kicked[i]);
    const Vec3<S> by = load3(bodies.place[i].at + 3) - rolling.turned[i];
    store3(so3_log(so3_exp(by) * so3_exp(rolling.turned[i])), bodies.place[i].at + 3);
  }
}

#define ATWOOD_ROLLING(S)                            \
  template void list_rolling<S>(World<S>&, S);       \
  template void turn_rolling_inertias<S>(World<S>&); \
  template void kick_rolling<S>(World<S>&, S);       \
  template void look_ahead<S>(World<S>&, S);         \
  template void turn_rolling<S>(World<S>&, S);
ATWOOD_ROLLING(float)
ATWOOD_ROLLING(double)
#undef ATWOOD_ROLLING

}  // namespace atwood::stepping
