// Contacts of any shapes: a manifold in each lane, its points solved one after another while the rows of both bodies
// stay in registers.
//
// With arms r_a, r_b to the point, an impulse P on b and -P on a changes the relative velocity there by K P,
//   K = (1/m_a + 1/m_b) 1 - [r_a] I_a^-1 [r_a] - [r_b] I_b^-1 [r_b].
#include "contact/stepping/contact_points.hpp"

namespace atwood::stepping {
namespace {

constexpr int kMinBatchesForTeam = 16;

// One body of eight contacts: v and w of the velocity row, I^-1 and 1/m of the inertia row.
template <class S> struct BodyLanes {
  Pack<S> velocity[kLaneCount], inertia[kLaneCount];
  ATWOOD_INLINE Vec3<Pack<S>> v() const { return linear_part<S>(velocity); }
  ATWOOD_INLINE Vec3<Pack<S>> w() const { return angular_part<S>(velocity); }
  ATWOOD_INLINE const Pack<S>& inverse_mass() const { return inertia[6]; }
  // I^-1 L of an angular impulse L
  ATWOOD_INLINE Vec3<Pack<S>> apply_inverse_inertia(const Vec3<Pack<S>>& L) const {
    return {inertia[0] * L.x + inertia[1] * L.y + inertia[2] * L.z,
            inertia[1] * L.x + inertia[3] * L.y + inertia[4] * L.z,
            inertia[2] * L.x + inertia[4] * L.y + inertia[5] * L.z};
  }
  ATWOOD_INLINE void apply_impulse(const Vec3<Pack<S>>& arm, const Vec3<Pack<S>>& P) {
    store_vector<S>(v() + inverse_mass() * P, velocity);
    store_vector<S>(w() + apply_inverse_inertia(cross(arm, P)), velocity + 3);
  }
  // Moves `pose` by a pseudo impulse P.
  ATWOOD_INLINE void displace(Pack<S> (&pose)[kLaneCount], const Vec3<Pack<S>>& arm, const Vec3<Pack<S>>& P) const {
    store_vector<S>(linear_part<S>(pose) + inverse_mass() * P, pose);
    store_vector<S>(angular_part<S>(pose) + apply_inverse_inertia(cross(arm, P)), pose + 3);
  }
  ATWOOD_INLINE void displace_back(Pack<S> (&pose)[kLaneCount], const Vec3<Pack<S>>& arm,
                                   const Vec3<Pack<S>>& P) const {
    store_vector<S>(linear_part<S>(pose) - inverse_mass() * P, pose);
    store_vector<S>(angular_part<S>(pose) - apply_inverse_inertia(cross(arm, P)), pose + 3);
  }
};

template <class S, VectorWidth width>
ATWOOD_INLINE void gather_bodies(const ManifoldBatch<S>& c, const Row<S>* velocities, const Row<S>* inertias,
                                 BodyLanes<S>& a, BodyLanes<S>& b) {
  gather<S, width>(velocities, c.a, a.velocity);
  gather<S, width>(velocities, c.b, b.velocity);
  gather<S, width>(inertias, c.a, a.inertia);
  gather<S, width>(inertias, c.b, b.inertia);
}

// Writes the rows of moving bodies only: a fixed body may be in several lanes, and in batches of several threads.
template <class S, VectorWidth width>
ATWOOD_INLINE void scatter_moving(const ManifoldBatch<S>& c, const unsigned char* moves, Pack<S> (&a)[kLaneCount],
                                  Pack<S> (&b)[kLaneCount], Row<S>* rows) {
  scatter<S, width>(a, c.a, c.count, rows);
  transpose<S, width>(b);
  for (int k = 0; k < kLaneCount; ++k)
    if (k < c.count && moves[c.b[k]]) store<S>(b[k], rows[c.b[k]].at);
}

template <class S, VectorWidth width> ATWOOD_INLINE Pack<S> inverse_or_zero(const Pack<S>& a) {
  return where_above<S, width>(a, broadcast(S(0)), S(1) / a, broadcast(S(0)));
}

// x where the lane has this point; 0 elsewhere.
template <class S, VectorWidth width>
ATWOOD_INLINE Pack<S> where_point_exists(const ManifoldPoint<S>& point, const Pack<S>& x) {
  return where_above<S, width>(broadcast(S(kMaxValue)), load(point.gap_at_detection.lane), x, broadcast(S(0)));
}

// Effective masses of a batch's points, with the arms of detection. Changes mass_n, mass_t and gradient_step_t.
template <class S, VectorWidth width>
ATWOOD_INLINE void set_effective_masses(ManifoldBatch<S>& c, const Row<S>* velocities, const Row<S>* inertias) {
  BodyLanes<S> a, b;
  gather_bodies<S, width>(c, velocities, inertias, a, b);
  const Vec3<Pack<S>> n = load_lanes<S>(c.normal), t = load_lanes<S>(c.tangent), s = cross(n, t);
  const Pack<S> linear = a.inverse_mass() + b.inverse_mass();
  for (int i = 0; i < c.points; ++i) {
    ManifoldPoint<S>& point = c.point[i];
    const Vec3<Pack<S>> r_a = load_lanes<S>(point.r_a), r_b = load_lanes<S>(point.r_b);
    const auto if_used = [&](const Pack<S>& x) ATWOOD_INLINED { return where_point_exists<S, width>(point, x); };
    const Vec3<Pack<S>> an = cross(r_a, n), bn = cross(r_b, n), at = cross(r_a, t), bt = cross(r_b, t),
                        as = cross(r_a, s), bs = cross(r_b, s);
    const Vec3<Pack<S>> Iat = a.apply_inverse_inertia(at), Ibt = b.apply_inverse_inertia(bt);
    const Pack<S> nn = linear + dot(an, a.apply_inverse_inertia(an)) + dot(bn, b.apply_inverse_inertia(bn));
    const Pack<S> tt = linear + dot(at, Iat) + dot(bt, Ibt), ts = dot(as, Iat) + dot(bs, Ibt);
    const Pack<S> ss = linear + dot(as, a.apply_inverse_inertia(as)) + dot(bs, b.apply_inverse_inertia(bs));
    store<S>(if_used(inverse_or_zero<S, width>(nn)), point.mass_n.lane);
    const Pack<S> by_determinant = inverse_or_zero<S, width>(tt * ss - ts * ts);
    store<S>(if_used(by_determinant * ss), point.mass_t[0].lane);
    store<S>(if_used(-by_determinant * ts), point.mass_t[1].lane);
    store<S>(if_used(by_determinant * tt), point.mass_t[2].lane);
    const Pack<S> half = S(0.5) * (tt - ss);
    const Pack<S> larger = S(0.5) * (tt + ss) + root(WholePack<width>{}, half * half + ts * ts);
    store<S>(if_used(inverse_or_zero<S, width>(larger)), point.gradient_step_t.lane);
  }
}

// Position correction of one point: displaces and rotates the overlapping bodies. True: some pose changed.
template <class S, VectorWidth width>
ATWOOD_INLINE bool correct_positions(const ManifoldBatch<S>& c, const ManifoldPoint<S>& point,
                                     const PositionCorrection<S>& correction, const Vec3<Pack<S>>& n,
                                     const AdvancedPoint<Pack<S>>& at, const BodyLanes<S>& a, const BodyLanes<S>& b,
                                     Pack<S> (&pose_a)[kLaneCount], Pack<S> (&pose_b)[kLaneCount]) {
  if (!(correction.share > S(0))) return false;
  const Pack<S> overlap =
      where_point_exists<S, width>(point, min<S, width>(at.gap + load(c.slop.lane), broadcast(S(0))));  // negative
  if (!any_above_zero<S, width>(-overlap)) return false;
  const Vec3<Pack<S>> push = (correction.share * overlap * load(point.mass_n.lane)) * n;  // on a
  a.displace(pose_a, at.arm_a, push);
  b.displace_back(pose_b, at.arm_b, push);
  return true;
}

// Displacements of the two bodies by the impacts of the substep.
template <class S> struct ShiftLanes { Pack<S> a[kLaneCount], b[kLaneCount]; };

// Velocity bias of one point. A gap of a millionth of the slop under a loaded contact counts as none, so that at rest
// the impulses of the last substep solve this one as they are. Changes point.bias.
template <class S, VectorWidth width>
ATWOOD_INLINE void update_bias(const ManifoldBatch<S>& c, ManifoldPoint<S>& point, const VelocityBias<S>& p,
                               const ShiftLanes<S>& shift, const Vec3<Pack<S>>& n, const AdvancedPoint<Pack<S>>& at) {
  const Pack<S> zero = broadcast(S(0));
  Pack<S> end_gap = at.gap;  // with the displacements that impacts add by the end of the substep
  if (p.impact_shift != nullptr)
    end_gap = end_gap + dot(n, (linear_part<S>(shift.b) + cross(angular_part<S>(shift.b), at.arm_b)) -
                                   (linear_part<S>(shift.a) + cross(angular_part<S>(shift.a), at.arm_a)));
  const Pack<S> impulse_n = load(point.impulse_n.lane), round_off = S(1e-6) * load(c.slop.lane);
  const Pack<S> allowed_gap = end_gap - where_above<S, width>(impulse_n, zero, round_off, zero);
  store<S>(max<S, width>(allowed_gap, zero) * (S(1) / p.sub_s), point.bias.lane);
}

// Warm start of one point: applies the impulse of the last substep. Off: sets it to 0. True: some velocity changed.
template <class S, VectorWidth width>
ATWOOD_INLINE bool apply_warm_start(ManifoldPoint<S>& point, WarmStart warm_start, const Vec3<Pack<S>>& n,
                                    const Vec3<Pack<S>>& t, const Vec3<Pack<S>>& s, const AdvancedPoint<Pack<S>>& at,
                                    BodyLanes<S>& a, BodyLanes<S>& b) {
  if (warm_start == WarmStart::off) {
    const Pack<S> zero = broadcast(S(0));
    store<S>(zero, point.impulse_n.lane);
    store<S>(zero, point.impulse_t[0].lane);
    store<S>(zero, point.impulse_t[1].lane);
    return false;
  }
  const Pack<S> jn = load(point.impulse_n.lane);
  if (!any_above_zero<S, width>(jn)) return false;
  const Vec3<Pack<S>> P = jn * n + load(point.impulse_t[0].lane) * t + load(point.impulse_t[1].lane) * s;
  a.apply_impulse(at.arm_a, -P);
  b.apply_impulse(at.arm_b, P);
  return true;
}

template <class S, VectorWidth width>
ATWOOD_INLINE void prepare(ManifoldBatch<S>& c, const Preparation<S>& p, Row<S>* poses, Row<S>* velocities,
                           const Row<S>* inertias, const unsigned char* moves) {
  BodyLanes<S> a, b;
  gather_bodies<S, width>(c, velocities, inertias, a, b);
  Pack<S> pose_a[kLaneCount], pose_b[kLaneCount];
  gather<S, width>(poses, c.a, pose_a);
  gather<S, width>(poses, c.b, pose_b);
  const Vec3<Pack<S>> n = load_lanes<S>(c.normal), t = load_lanes<S>(c.tangent), s = cross(n, t);
  const Rounding<Pack<S>> rounding_a{load_lanes<S>(c.rounding_axis_a), load(c.rounding_radius_a.lane)};
  const Rounding<Pack<S>> rounding_b{load_lanes<S>(c.rounding_axis_b), load(c.rounding_radius_b.lane)};
  const Vec3<Pack<S>> rotation_a = load_lanes<S>(c.rotation_a), rotation_b = load_lanes<S>(c.rotation_b);
  const Pack<S> witness_offset = load(c.witness_offset.lane);
  ShiftLanes<S> shift;
  if (p.velocity_bias.impact_shift != nullptr) {
    gather<S, width>(p.velocity_bias.impact_shift, c.a, shift.a);
    gather<S, width>(p.velocity_bias.impact_shift, c.b, shift.b);
  }
  bool corrected = false, warm_started = false;
  for (int i = 0; i < c.points; ++i) {
    ManifoldPoint<S>& point = c.point[i];
    const AdvancedPoint<Pack<S>> at = advance_point<S, Pack<S>>(
        n, load_lanes<S>(point.r_a), load_lanes<S>(point.r_b), load(point.gap_at_detection.lane),
        linear_part<S>(pose_b) - linear_part<S>(pose_a), angular_part<S>(pose_a) - rotation_a,
        angular_part<S>(pose_b) - rotation_b, rounding_a, rounding_b, witness_offset);
    store<S>(at.gap, point.gap.lane);
    store_lanes<S>(at.arm_a, point.arm_a);
    store_lanes<S>(at.arm_b, point.arm_b);
    corrected |= correct_positions<S, width>(c, point, p.position_correction, n, at, a, b, pose_a, pose_b);
    update_bias<S, width>(c, point, p.velocity_bias, shift, n, at);
    warm_started |= apply_warm_start<S, width>(point, p.warm_start, n, t, s, at, a, b);
  }
  if (corrected) scatter_moving<S, width>(c, moves, pose_a, pose_b, poses);
  if (warm_started) scatter_moving<S, width>(c, moves, a.velocity, b.velocity, velocities);
}

// One iteration of projected Gauss-Seidel (sequential impulses) over a manifold's points, the normal impulse first:
//   P_n <- max(0, P_n - mass_n (u_n + bias))
// then the two tangential ones together. If the impulses that stop the slip lie inside the disc of radius mu P_n, they
// are taken; else a step of projected gradient, whose fixed point has friction opposite to the slip for every K:
//   P_t <- project(P_t - gradient_step_t u_t, disc of radius mu P_n)
template <class S, VectorWidth width>
ATWOOD_INLINE void solve(ManifoldBatch<S>& c, Row<S>* velocities, const Row<S>* inertias, const unsigned char* moves) {
  BodyLanes<S> a, b;
  gather_bodies<S, width>(c, velocities, inertias, a, b);
  const Vec3<Pack<S>> n = load_lanes<S>(c.normal), t = load_lanes<S>(c.tangent), s = cross(n, t);
  const Pack<S> zero = broadcast(S(0)), mu = load(c.friction.lane);
  for (int i = 0; i < c.points; ++i) {
    ManifoldPoint<S>& point = c.point[i];
    const Vec3<Pack<S>> r_a = load_lanes<S>(point.arm_a), r_b = load_lanes<S>(point.arm_b);
    Vec3<Pack<S>> u = (b.v() + cross(b.w(), r_b)) - (a.v() + cross(a.w(), r_a));
    const Pack<S> jn_old = load(point.impulse_n.lane);
    const Pack<S> jn = max<S, width>(jn_old - load(point.mass_n.lane) * (dot(u, n) + load(point.bias.lane)), zero);
    store<S>(jn, point.impulse_n.lane);
    const Vec3<Pack<S>> dn = (jn - jn_old) * n;
    a.apply_impulse(r_a, -dn);
    b.apply_impulse(r_b, dn);

    u = (b.v() + cross(b.w(), r_b)) - (a.v() + cross(a.w(), r_a));
    Pack<S> ut = dot(u, t), us = dot(u, s);
    if (c.has_surface_velocity) {
      ut += load(c.surface_velocity[i][0].lane);
      us += load(c.surface_velocity[i][1].lane);
    }
    const Pack<S> limit = mu * jn;
    const Pack<S> t_old = load(point.impulse_t[0].lane), s_old = load(point.impulse_t[1].lane);
    const Pack<S> m11 = load(point.mass_t[0].lane), m12 = load(point.mass_t[1].lane), m22 = load(point.mass_t[2].lane);
    const Pack<S> stick_t = t_old - (m11 * ut + m12 * us), stick_s = s_old - (m12 * ut + m22 * us);
    const Pack<S> stick2 = stick_t * stick_t + stick_s * stick_s, limit2 = limit * limit;
    const Pack<S> step = load(point.gradient_step_t.lane);
    const Pack<S> slip_t = t_old - step * ut, slip_s = s_old - step * us;
    const Pack<S> size = root(WholePack<width>{}, slip_t * slip_t + slip_s * slip_s);
    const Pack<S> factor = where_above<S, width>(size, limit, limit / size, broadcast(S(1)));
    const Pack<S> jt = where_above<S, width>(stick2, limit2, factor * slip_t, stick_t);
    const Pack<S> js = where_above<S, width>(stick2, limit2, factor * slip_s, stick_s);
    store<S>(jt, point.impulse_t[0].lane);
    store<S>(js, point.impulse_t[1].lane);
    const Vec3<Pack<S>> dt = (jt - t_old) * t + (js - s_old) * s;
    a.apply_impulse(r_a, -dt);
    b.apply_impulse(r_b, dt);
  }
  scatter_moving<S, width>(c, moves, a.velocity, b.velocity, velocities);
}

// visit(batch, width) of all batches, colour by colour.
template <class S, class Visit> void for_all_batches(World<S>& world, const Visit& visit) {
  for (const Colour& colour : world.manifold_contacts.colours)
    for_batches(world, colour.first, colour.last, kMinBatchesForTeam,
                [&](int first, int last, auto width) ATWOOD_INLINED {
                  ManifoldBatch<S>* batches = world.manifold_contacts.batches.data();
                  for (int i = first; i < last; ++i) visit(batches[i], width);
                });
}

}  // namespace

template <class S> void update_effective_masses(World<S>& world) {
  const Row<S>*velocities = world.bodies.velocity.data(), *inertias = world.bodies.inertia.data();
  for_all_batches(world, [&](ManifoldBatch<S>& batch, auto width)
                             ATWOOD_INLINED { set_effective_masses<S, width()>(batch, velocities, inertias); });
}

template <class S> void update_effective_masses_of(World<S>& world, ManifoldBatch<S>& batch) {
  set_effective_masses<S, VectorWidth::narrow>(batch, world.bodies.velocity.data(), world.bodies.inertia.data());
}

template <class S> void prepare_manifold_contacts(World<S>& world, const Preparation<S>& preparation) {
  Row<S>*poses = world.bodies.pose.data(), *velocities = world.bodies.velocity.data();
  const Row<S>* inertias = world.bodies.inertia.data();
  const unsigned char* moves = world.bodies.moves.data();
  for_all_batches(world, [&](ManifoldBatch<S>& batch, auto width) ATWOOD_INLINED {
    prepare<S, width()>(batch, preparation, poses, velocities, inertias, moves);
  });
}

template <class S> void solve_manifold_contacts(World<S>& world) {
  Row<S>* velocities = world.bodies.velocity.data();
  const Row<S>* inertias = world.bodies.inertia.data();
  const unsigned char* moves = world.bodies.moves.data();
  for_all_batches(world, [&](ManifoldBatch<S>& batch, auto width)
                             ATWOOD_INLINED { solve<S, width()>(batch, velocities, inertias, moves); });
}

#define ATWOOD_MANIFOLD_CONTACTS(S)                                             \
  template void update_effective_masses<S>(World<S>&);                          \
  template void update_effective_masses_of<S>(World<S>&, ManifoldBatch<S>&);    \
  template void prepare_manifold_contacts<S>(World<S>&, const Preparation<S>&); \
  template void solve_manifold_contacts<S>(World<S>&);
ATWOOD_MANIFOLD_CONTACTS(float)
ATWOOD_MANIFOLD_CONTACTS(double)
#undef ATWOOD_MANIFOLD_CONTACTS

}  // namespace atwood::stepping
