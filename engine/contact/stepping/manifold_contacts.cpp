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
template <class S, VectorWidth width> struct BodyLanes {
  PackAt<S, width> velocity[kLaneCount], inertia[kLaneCount];
  ATWOOD_INLINE Vec3<PackAt<S, width>> v() const { return linear_part(velocity); }
  ATWOOD_INLINE Vec3<PackAt<S, width>> w() const { return angular_part(velocity); }
  ATWOOD_INLINE const PackAt<S, width>& inverse_mass() const { return inertia[6]; }
  // I^-1 L of an angular impulse L
  ATWOOD_INLINE Vec3<PackAt<S, width>> apply_inverse_inertia(const Vec3<PackAt<S, width>>& L) const {
    return {inertia[0] * L.x + inertia[1] * L.y + inertia[2] * L.z,
            inertia[1] * L.x + inertia[3] * L.y + inertia[4] * L.z,
            inertia[2] * L.x + inertia[4] * L.y + inertia[5] * L.z};
  }
  ATWOOD_INLINE void apply_impulse(const Vec3<PackAt<S, width>>& arm, const Vec3<PackAt<S, width>>& P) {
    store_vector(v() + inverse_mass() * P, velocity);
    store_vector(w() + apply_inverse_inertia(cross(arm, P)), velocity + 3);
  }
  // Moves `pose` by a pseudo impulse P.
  ATWOOD_INLINE void displace(PackAt<S, width> (&pose)[kLaneCount], const Vec3<PackAt<S, width>>& arm,
                              const Vec3<PackAt<S, width>>& P) const {
    store_vector(linear_part(pose) + inverse_mass() * P, pose);
    store_vector(angular_part(pose) + apply_inverse_inertia(cross(arm, P)), pose + 3);
  }
  ATWOOD_INLINE void displace_back(PackAt<S, width> (&pose)[kLaneCount], const Vec3<PackAt<S, width>>& arm,
                                   const Vec3<PackAt<S, width>>& P) const {
    store_vector(linear_part(pose) - inverse_mass() * P, pose);
    store_vector(angular_part(pose) - apply_inverse_inertia(cross(arm, P)), pose + 3);
  }
};

template <class S, VectorWidth width>
ATWOOD_INLINE void gather_bodies(const ManifoldBatch<S>& c, const Row<S>* velocities, const Row<S>* inertias,
                                 BodyLanes<S, width>& a, BodyLanes<S, width>& b) {
  gather<S, width>(velocities, c.a, a.velocity);
  gather<S, width>(velocities, c.b, b.velocity);
  gather<S, width>(inertias, c.a, a.inertia);
  gather<S, width>(inertias, c.b, b.inertia);
}

// Writes the rows of moving bodies only: a fixed body may be in several lanes, and in batches of several threads.
template <class S, VectorWidth width>
ATWOOD_INLINE void scatter_moving(const ManifoldBatch<S>& c, const unsigned char* moves,
                                  PackAt<S, width> (&a)[kLaneCount], PackAt<S, width> (&b)[kLaneCount], Row<S>* rows) {
  scatter<S, width>(a, c.a, c.count, rows);
  transpose(b);
  for (int k = 0; k < kLaneCount; ++k)
    if (k < c.count && moves[c.b[k]]) store<S>(b[k], rows[c.b[k]].at);
}

template <class S, VectorWidth width> ATWOOD_INLINE PackAt<S, width> inverse_or_zero(const PackAt<S, width>& a) {
  return where_above(a, broadcast_at<width>(S(0)), S(1) / a, broadcast_at<width>(S(0)));
}

// x where the lane has this point; 0 elsewhere.
template <class S, VectorWidth width>
ATWOOD_INLINE PackAt<S, width> where_point_exists(const ManifoldPoint<S>& point, const PackAt<S, width>& x) {
  return where_above(broadcast_at<width>(S(kMaxValue)), load_at<width>(point.gap_at_detection.lane), x,
                     broadcast_at<width>(S(0)));
}

// Effective masses of a batch's points, with the arms of detection. Changes mass_n, mass_t and gradient_step_t.
template <class S, VectorWidth width>
ATWOOD_INLINE void set_effective_masses(ManifoldBatch<S>& c, const Row<S>* velocities, const Row<S>* inertias) {
  BodyLanes<S, width> a, b;
  gather_bodies<S, width>(c, velocities, inertias, a, b);
  const Vec3<PackAt<S, width>> n = load_lanes<S, width>(c.normal), t = load_lanes<S, width>(c.tangent), s = cross(n, t);
  const PackAt<S, width> linear = a.inverse_mass() + b.inverse_mass();
  for (int i = 0; i < c.points; ++i) {
    ManifoldPoint<S>& point = c.point[i];
    const Vec3<PackAt<S, width>> r_a = load_lanes<S, width>(point.r_a), r_b = load_lanes<S, width>(point.r_b);
    const auto if_used = [&](const PackAt<S, width>& x)
                             ATWOOD_INLINED { return where_point_exists<S, width>(point, x); };
    const Vec3<PackAt<S, width>> an = cross(r_a, n), bn = cross(r_b, n), at = cross(r_a, t), bt = cross(r_b, t),
                                 as = cross(r_a, s), bs = cross(r_b, s);
    const Vec3<PackAt<S, width>> Iat = a.apply_inverse_inertia(at), Ibt = b.apply_inverse_inertia(bt);
    const PackAt<S, width> nn = linear + dot(an, a.apply_inverse_inertia(an)) + dot(bn, b.apply_inverse_inertia(bn));
    const PackAt<S, width> tt = linear + dot(at, Iat) + dot(bt, Ibt), ts = dot(as, Iat) + dot(bs, Ibt);
    const PackAt<S, width> ss = linear + dot(as, a.apply_inverse_inertia(as)) + dot(bs, b.apply_inverse_inertia(bs));
    store<S>(if_used(inverse_or_zero<S, width>(nn)), point.mass_n.lane);
    const PackAt<S, width> by_determinant = inverse_or_zero<S, width>(tt * ss - ts * ts);
    store<S>(if_used(by_determinant * ss), point.mass_t[0].lane);
    store<S>(if_used(-by_determinant * ts), point.mass_t[1].lane);
    store<S>(if_used(by_determinant * tt), point.mass_t[2].lane);
    const PackAt<S, width> half = S(0.5) * (tt - ss);
    const PackAt<S, width> larger = S(0.5) * (tt + ss) + root(WholePack<width>{}, half * half + ts * ts);
    store<S>(if_used(inverse_or_zero<S, width>(larger)), point.gradient_step_t.lane);
  }
}

// Position correction of one point: displaces and rotates the overlapping bodies. True: some pose changed.
template <class S, VectorWidth width>
ATWOOD_INLINE bool correct_positions(const ManifoldBatch<S>& c, const ManifoldPoint<S>& point,
                                     const PositionCorrection<S>& correction, const Vec3<PackAt<S, width>>& n,
                                     const AdvancedPoint<PackAt<S, width>>& at, const BodyLanes<S, width>& a,
                                     const BodyLanes<S, width>& b, PackAt<S, width> (&pose_a)[kLaneCount],
                                     PackAt<S, width> (&pose_b)[kLaneCount]) {
  if (!(correction.share > S(0))) return false;
  const PackAt<S, width> overlap = where_point_exists<S, width>(
      point, min(at.gap + load_at<width>(c.slop.lane), broadcast_at<width>(S(0))));  // negative
  if (!any_above_zero<S, width>(-overlap)) return false;
  const Vec3<PackAt<S, width>> push = (correction.share * overlap * load_at<width>(point.mass_n.lane)) * n;  // on a
  a.displace(pose_a, at.arm_a, push);
  b.displace_back(pose_b, at.arm_b, push);
  return true;
}

// Displacements of the two bodies by the impacts of the substep.
template <class S, VectorWidth width> struct ShiftLanes { PackAt<S, width> a[kLaneCount], b[kLaneCount]; };

// Velocity bias of one point. A gap of a millionth of the slop under a loaded contact counts as none, so that at rest
// the impulses of the last substep solve this one as they are. Changes point.bias.
template <class S, VectorWidth width>
ATWOOD_INLINE void update_bias(const ManifoldBatch<S>& c, ManifoldPoint<S>& point, const VelocityBias<S>& p,
                               const ShiftLanes<S, width>& shift, const Vec3<PackAt<S, width>>& n,
                               const AdvancedPoint<PackAt<S, width>>& at) {
  const PackAt<S, width> zero = broadcast_at<width>(S(0));
  PackAt<S, width> end_gap = at.gap;  // with the displacements that impacts add by the end of the substep
  if (p.impact_shift != nullptr)
    end_gap = end_gap + dot(n, (linear_part(shift.b) + cross(angular_part(shift.b), at.arm_b)) -
                                   (linear_part(shift.a) + cross(angular_part(shift.a), at.arm_a)));
  const PackAt<S, width> impulse_n = load_at<width>(point.impulse_n.lane),
                         round_off = S(1e-6) * load_at<width>(c.slop.lane);
  const PackAt<S, width> allowed_gap = end_gap - where_above(impulse_n, zero, round_off, zero);
  store<S>(max(allowed_gap, zero) * (S(1) / p.sub_s), point.bias.lane);
}

// Warm start of one point: applies the impulse of the last substep. Off: sets it to 0. True: some velocity changed.
template <class S, VectorWidth width>
ATWOOD_INLINE bool apply_warm_start(ManifoldPoint<S>& point, WarmStart warm_start, const Vec3<PackAt<S, width>>& n,
                                    const Vec3<PackAt<S, width>>& t, const Vec3<PackAt<S, width>>& s,
                                    const AdvancedPoint<PackAt<S, width>>& at, BodyLanes<S, width>& a,
                                    BodyLanes<S, width>& b) {
  if (warm_start == WarmStart::off) {
    const PackAt<S, width> zero = broadcast_at<width>(S(0));
    store<S>(zero, point.impulse_n.lane);
    store<S>(zero, point.impulse_t[0].lane);
    store<S>(zero, point.impulse_t[1].lane);
    return false;
  }
  const PackAt<S, width> jn = load_at<width>(point.impulse_n.lane);
  if (!any_above_zero<S, width>(jn)) return false;
  const Vec3<PackAt<S, width>> P =
      jn * n + load_at<width>(point.impulse_t[0].lane) * t + load_at<width>(point.impulse_t[1].lane) * s;
  a.apply_impulse(at.arm_a, -P);
  b.apply_impulse(at.arm_b, P);
  return true;
}

template <class S, VectorWidth width>
ATWOOD_INLINE void prepare(ManifoldBatch<S>& c, const Preparation<S>& p, Row<S>* poses, Row<S>* velocities,
                           const Row<S>* inertias, const unsigned char* moves) {
  BodyLanes<S, width> a, b;
  gather_bodies<S, width>(c, velocities, inertias, a, b);
  PackAt<S, width> pose_a[kLaneCount], pose_b[kLaneCount];
  gather<S, width>(poses, c.a, pose_a);
  gather<S, width>(poses, c.b, pose_b);
  const Vec3<PackAt<S, width>> n = load_lanes<S, width>(c.normal), t = load_lanes<S, width>(c.tangent), s = cross(n, t);
  const Rounding<PackAt<S, width>> rounding_a{load_lanes<S, width>(c.rounding_axis_a),
                                              load_at<width>(c.rounding_radius_a.lane)};
  const Rounding<PackAt<S, width>> rounding_b{load_lanes<S, width>(c.rounding_axis_b),
                                              load_at<width>(c.rounding_radius_b.lane)};
  const Vec3<PackAt<S, width>> rotation_a = load_lanes<S, width>(c.rotation_a),
                               rotation_b = load_lanes<S, width>(c.rotation_b);
  const PackAt<S, width> witness_offset = load_at<width>(c.witness_offset.lane);
  ShiftLanes<S, width> shift;
  if (p.velocity_bias.impact_shift != nullptr) {
    gather<S, width>(p.velocity_bias.impact_shift, c.a, shift.a);
    gather<S, width>(p.velocity_bias.impact_shift, c.b, shift.b);
  }
  bool corrected = false, warm_started = false;
  for (int i = 0; i < c.points; ++i) {
    ManifoldPoint<S>& point = c.point[i];
    const AdvancedPoint<PackAt<S, width>> at = advance_point<S, PackAt<S, width>>(
        n, load_lanes<S, width>(point.r_a), load_lanes<S, width>(point.r_b),
        load_at<width>(point.gap_at_detection.lane), linear_part(pose_b) - linear_part(pose_a),
        angular_part(pose_a) - rotation_a, angular_part(pose_b) - rotation_b, rounding_a, rounding_b, witness_offset);
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
  BodyLanes<S, width> a, b;
  gather_bodies<S, width>(c, velocities, inertias, a, b);
  const Vec3<PackAt<S, width>> n = load_lanes<S, width>(c.normal), t = load_lanes<S, width>(c.tangent), s = cross(n, t);
  const PackAt<S, width> zero = broadcast_at<width>(S(0)), mu = load_at<width>(c.friction.lane);
  for (int i = 0; i < c.points; ++i) {
    ManifoldPoint<S>& point = c.point[i];
    const Vec3<PackAt<S, width>> r_a = load_lanes<S, width>(point.arm_a), r_b = load_lanes<S, width>(point.arm_b);
    Vec3<PackAt<S, width>> u = (b.v() + cross(b.w(), r_b)) - (a.v() + cross(a.w(), r_a));
    const PackAt<S, width> jn_old = load_at<width>(point.impulse_n.lane);
    const PackAt<S, width> jn =
        max(jn_old - load_at<width>(point.mass_n.lane) * (dot(u, n) + load_at<width>(point.bias.lane)), zero);
    store<S>(jn, point.impulse_n.lane);
    const Vec3<PackAt<S, width>> dn = (jn - jn_old) * n;
    a.apply_impulse(r_a, -dn);
    b.apply_impulse(r_b, dn);

    u = (b.v() + cross(b.w(), r_b)) - (a.v() + cross(a.w(), r_a));
    PackAt<S, width> ut = dot(u, t), us = dot(u, s);
    if (c.has_surface_velocity) {
      ut = ut + load_at<width>(c.surface_velocity[i][0].lane);
      us = us + load_at<width>(c.surface_velocity[i][1].lane);
    }
    const PackAt<S, width> limit = mu * jn;
    const PackAt<S, width> t_old = load_at<width>(point.impulse_t[0].lane),
                           s_old = load_at<width>(point.impulse_t[1].lane);
    const PackAt<S, width> m11 = load_at<width>(point.mass_t[0].lane), m12 = load_at<width>(point.mass_t[1].lane),
                           m22 = load_at<width>(point.mass_t[2].lane);
    const PackAt<S, width> stick_t = t_old - (m11 * ut + m12 * us), stick_s = s_old - (m12 * ut + m22 * us);
    const PackAt<S, width> stick2 = stick_t * stick_t + stick_s * stick_s, limit2 = limit * limit;
    const PackAt<S, width> step = load_at<width>(point.gradient_step_t.lane);
    const PackAt<S, width> slip_t = t_old - step * ut, slip_s = s_old - step * us;
    const PackAt<S, width> size = root(WholePack<width>{}, slip_t * slip_t + slip_s * slip_s);
    const PackAt<S, width> factor = where_above(size, limit, limit / size, broadcast_at<width>(S(1)));
    const PackAt<S, width> jt = where_above(stick2, limit2, factor * slip_t, stick_t);
    const PackAt<S, width> js = where_above(stick2, limit2, factor * slip_s, stick_s);
    store<S>(jt, point.impulse_t[0].lane);
    store<S>(js, point.impulse_t[1].lane);
    const Vec3<PackAt<S, width>> dt = (jt - t_old) * t + (js - s_old) * s;
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
