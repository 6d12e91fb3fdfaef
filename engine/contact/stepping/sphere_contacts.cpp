// Contacts of spheres with spheres and planes: their inertia is isotropic and their arms lie along the normal, so the
// solver needs no matrices and handles eight at a time.
//
// Relative velocity at the point midway between the surfaces, arms r_a = arm_a n and r_b = -arm_b n:
//   u = v_b - v_a - (arm_a w_a + arm_b w_b) x n
// An impulse P on b, -P on a changes u by P_n / mass_n + P_t / mass_t: normal and tangential parts are decoupled.
#include "contact/stepping/contact_points.hpp"

namespace atwood::stepping {
namespace {

constexpr int kMinBatchesForTeam = 48;  // some 5 us of work

// Velocities (or poses) of the two bodies of eight contacts.
template <class S, VectorWidth width> struct BodyPairLanes { PackAt<S, width> a[kLaneCount], b[kLaneCount]; };

template <class S, SpherePartner partner, VectorWidth width>
ATWOOD_INLINE void gather_velocities(const SphereBatch<S>& c, const Row<S>* velocities, BodyPairLanes<S, width>& out) {
  gather<S, width>(velocities, c.a, out.a);
  if constexpr (partner == SpherePartner::moving_sphere) gather<S, width>(velocities, c.b, out.b);
  else set_zero<width>(out.b);
}

// Writes back what a contact may change: the rows of its moving bodies.
template <class S, SpherePartner partner, VectorWidth width>
ATWOOD_INLINE void scatter_moving(BodyPairLanes<S, width>& rows, const SphereBatch<S>& c, Row<S>* to) {
  scatter<S, width>(rows.a, c.a, c.count, to);
  if constexpr (partner == SpherePartner::moving_sphere) scatter<S, width>(rows.b, c.b, c.count, to);
}

// Applies P to b at -arm_b n and -P to a at arm_a n; `moment` is n x P.
template <class S, SpherePartner partner, VectorWidth width>
ATWOOD_INLINE void apply_impulse(BodyPairLanes<S, width>& v, const PackAt<S, width>& arm_a,
                                 const PackAt<S, width>& arm_b, const Vec3<PackAt<S, width>>& P,
                                 const Vec3<PackAt<S, width>>& moment) {
  store_vector(linear_part(v.a) - v.a[6] * P, v.a);
  store_vector(angular_part(v.a) - (arm_a * v.a[7]) * moment, v.a + 3);
  if constexpr (partner == SpherePartner::moving_sphere) {
    store_vector(linear_part(v.b) + v.b[6] * P, v.b);
    store_vector(angular_part(v.b) - (arm_b * v.b[7]) * moment, v.b + 3);
  }
}

// Sets the normal n, the vector d from a's centre to b's (of a plane: along n to the plane), and the gap. Where the
// centres coincide, n stays as it was.
template <class S, SpherePartner partner, VectorWidth width>
ATWOOD_INLINE void update_gap(const SphereBatch<S>& c, const BodyPairLanes<S, width>& pose, Vec3<PackAt<S, width>>& n,
                              Vec3<PackAt<S, width>>& d, PackAt<S, width>& gap) {
  const PackAt<S, width> radii = load_at<width>(c.radius_a.lane) + load_at<width>(c.radius_b.lane);
  n = load_lanes<S, width>(c.normal);
  if constexpr (partner == SpherePartner::plane) {
    gap = -dot(n, linear_part(pose.a)) - radii;
    d = (gap + radii) * n;
  } else {
    d = linear_part(pose.b) - linear_part(pose.a);
    const PackAt<S, width> distance = root(WholePack<width>{}, dot(d, d));
    const PackAt<S, width> inverse = S(1) / distance, zero = broadcast_at<width>(S(0));
    n.x = where_above(distance, zero, inverse * d.x, n.x);
    n.y = where_above(distance, zero, inverse * d.y, n.y);
    n.z = where_above(distance, zero, inverse * d.z, n.z);
    gap = distance - radii;
  }
}

// Position correction: moves overlapping spheres apart along the normal. Changes positions.
template <class S, SpherePartner partner, VectorWidth width>
ATWOOD_INLINE void correct_positions(const SphereBatch<S>& c, const PositionCorrection<S>& correction,
                                     const Vec3<PackAt<S, width>>& n, const PackAt<S, width>& gap,
                                     const BodyPairLanes<S, width>& v, BodyPairLanes<S, width>& pose, Row<S>* poses) {
  if (!(correction.share > S(0))) return;
  const PackAt<S, width> overlap = min(gap + load_at<width>(c.slop.lane), broadcast_at<width>(S(0)));  // negative
  if (!any_above_zero<S, width>(-overlap)) return;
  const Vec3<PackAt<S, width>> push = (correction.share * overlap * load_at<width>(c.mass_n.lane)) * n;
  store_vector(linear_part(pose.a) + v.a[6] * push, pose.a);
  if constexpr (partner == SpherePartner::moving_sphere) store_vector(linear_part(pose.b) - v.b[6] * push, pose.b);
  scatter_moving<S, partner, width>(pose, c, poses);
}

// Arms to the point midway between the surfaces, and the effective mass across the normal. Changes the batch.
template <class S, SpherePartner partner, VectorWidth width>
ATWOOD_INLINE void update_arms(SphereBatch<S>& c, const PackAt<S, width>& gap, const BodyPairLanes<S, width>& v,
                               PackAt<S, width>& arm_a, PackAt<S, width>& arm_b) {
  const PackAt<S, width> zero = broadcast_at<width>(S(0)), half = S(0.5) * gap;
  arm_a = load_at<width>(c.radius_a.lane) + half;
  arm_b = partner == SpherePartner::plane ? zero : load_at<width>(c.radius_b.lane) + half;
  store<S>(arm_a, c.arm_a.lane);
  store<S>(arm_b, c.arm_b.lane);
  const PackAt<S, width> mobility_t = v.a[6] + v.b[6] + arm_a * arm_a * v.a[7] + arm_b * arm_b * v.b[7];
  store<S>(where_above(mobility_t, zero, S(1) / mobility_t, zero), c.mass_t.lane);
}

// Velocity bias, and whether the batch is active. A contact without impulse whose spheres miss each other within the
// substep, at their present velocities, gets the bias kNoValue: it is not a constraint. Changes the batch.
template <class S, SpherePartner partner, VectorWidth width>
ATWOOD_INLINE void update_bias(SphereBatch<S>& c, const VelocityBias<S>& p, const Vec3<PackAt<S, width>>& n,
                               Vec3<PackAt<S, width>> d, const PackAt<S, width>& gap,
                               const BodyPairLanes<S, width>& v) {
  const PackAt<S, width> zero = broadcast_at<width>(S(0)), impulse_n = load_at<width>(c.impulse_n.lane);
  PackAt<S, width> end_gap = gap;  // with the displacements that impacts add by the end of the substep
  if (p.impact_shift != nullptr) {
    BodyPairLanes<S, width> shift_of;
    gather_velocities<S, partner, width>(c, p.impact_shift, shift_of);
    const Vec3<PackAt<S, width>> shift = linear_part(shift_of.b) - linear_part(shift_of.a);
    end_gap = end_gap + dot(n, shift);
    d = d + shift;
  }
  PackAt<S, width> bias = max(end_gap, zero) * (S(1) / p.sub_s);
  const Vec3<PackAt<S, width>> u = linear_part(v.b) - linear_part(v.a);
  if constexpr (partner != SpherePartner::plane) {
    // least distance |d + u s| over s in [0, sub_s]
    const PackAt<S, width> uu = dot(u, u), du = dot(d, u);
    PackAt<S, width> s = where_above(uu, zero, -du / uu, zero);
    s = min(max(s, zero), broadcast_at<width>(p.sub_s));
    const Vec3<PackAt<S, width>> nearest = d + s * u;
    const PackAt<S, width> radii = load_at<width>(c.radius_a.lane) + load_at<width>(c.radius_b.lane);
    const PackAt<S, width> misses = where_above(dot(nearest, nearest), radii * radii, broadcast_at<width>(S(1)), zero);
    const PackAt<S, width> passes = where_above(end_gap, zero, where_above(impulse_n, zero, zero, misses), zero);
    bias = where_above(passes, zero, broadcast_at<width>(S(kNoValue)), bias);
  }
  store<S>(bias, c.bias.lane);

  // Neighbours may push the spheres closer together than their own velocities do: twice the way, and 1 % of the radius.
  const PackAt<S, width> un = dot(u, n), radius_a = load_at<width>(c.radius_a.lane);
  const PackAt<S, width> approach = S(0.01) * radius_a + S(2) * p.sub_s * max(un, -un) - min(gap, end_gap);
  c.active = any_above_zero<S, width>(max(approach, impulse_n));
}

// Warm start: applies the impulses of the last substep, the tangential one turned into the new tangent plane. Off: sets
// them to 0. Changes velocities and impulses.
template <class S, SpherePartner partner, VectorWidth width>
ATWOOD_INLINE void apply_warm_start(SphereBatch<S>& c, WarmStart warm_start, const Vec3<PackAt<S, width>>& n,
                                    const PackAt<S, width>& arm_a, const PackAt<S, width>& arm_b,
                                    BodyPairLanes<S, width>& v, Row<S>* velocities) {
  const PackAt<S, width> zero = broadcast_at<width>(S(0)), impulse_n = load_at<width>(c.impulse_n.lane);
  Vec3<PackAt<S, width>> t = load_lanes<S, width>(c.impulse_t);
  if (warm_start == WarmStart::off) {
    store<S>(zero, c.impulse_n.lane);
    store_lanes<S>(Vec3<PackAt<S, width>>{zero, zero, zero}, c.impulse_t);
    return;
  }
  if (!any_above_zero<S, width>(impulse_n)) return;
  t = t - dot(t, n) * n;
  store_lanes<S>(t, c.impulse_t);
  apply_impulse<S, partner, width>(v, arm_a, arm_b, impulse_n * n + t, cross(n, t));
  scatter_moving<S, partner, width>(v, c, velocities);
}

template <class S, SpherePartner partner, VectorWidth width>
ATWOOD_INLINE void prepare(SphereBatch<S>& c, const Preparation<S>& p, Row<S>* poses, Row<S>* velocities) {
  BodyPairLanes<S, width> pose, v;
  gather<S, width>(poses, c.a, pose.a);
  if constexpr (partner != SpherePartner::plane) gather<S, width>(poses, c.b, pose.b);
  else set_zero<width>(pose.b);
  gather_velocities<S, partner, width>(c, velocities, v);
  Vec3<PackAt<S, width>> n, d;
  PackAt<S, width> gap, arm_a, arm_b;
  update_gap<S, partner, width>(c, pose, n, d, gap);
  store_lanes<S>(n, c.normal);
  store<S>(gap, c.gap.lane);
  correct_positions<S, partner, width>(c, p.position_correction, n, gap, v, pose, poses);
  update_arms<S, partner, width>(c, gap, v, arm_a, arm_b);
  update_bias<S, partner, width>(c, p.velocity_bias, n, d, gap, v);
  apply_warm_start<S, partner, width>(c, p.warm_start, n, arm_a, arm_b, v, velocities);
}

// One iteration of projected Gauss-Seidel (sequential impulses): the normal impulse stays >= 0, the tangential one
// inside the disc of the round friction cone.
//   P_n <- max(0, P_n - mass_n (u_n + bias))
//   P_t <- project(P_t - mass_t u_t, disc of radius mu P_n)
template <class S, SpherePartner partner, VectorWidth width>
ATWOOD_INLINE void solve(SphereBatch<S>& c, Row<S>* velocities) {
  BodyPairLanes<S, width> v;
  gather_velocities<S, partner, width>(c, velocities, v);
  const PackAt<S, width> zero = broadcast_at<width>(S(0)), arm_a = load_at<width>(c.arm_a.lane),
                         arm_b = load_at<width>(c.arm_b.lane);
  const Vec3<PackAt<S, width>> n = load_lanes<S, width>(c.normal);
  const Vec3<PackAt<S, width>> linear = linear_part(v.b) - linear_part(v.a);
  const PackAt<S, width> un = dot(linear, n);
  const PackAt<S, width> jn_old = load_at<width>(c.impulse_n.lane);
  const PackAt<S, width> jn = max(jn_old - load_at<width>(c.mass_n.lane) * (un + load_at<width>(c.bias.lane)), zero);
  store<S>(jn, c.impulse_n.lane);

  const Vec3<PackAt<S, width>> angular = arm_a * angular_part(v.a) + arm_b * angular_part(v.b);
  const Vec3<PackAt<S, width>> ut = linear - un * n - cross(angular, n);
  const Vec3<PackAt<S, width>> t_old = load_lanes<S, width>(c.impulse_t);
  Vec3<PackAt<S, width>> t = t_old - load_at<width>(c.mass_t.lane) * ut;
  const PackAt<S, width> size = root(WholePack<width>{}, dot(t, t)), limit = load_at<width>(c.friction.lane) * jn;
  const PackAt<S, width> factor = where_above(size, limit, limit / size, broadcast_at<width>(S(1)));
  t = factor * t;
  store_lanes<S>(t, c.impulse_t);

  const Vec3<PackAt<S, width>> dt = t - t_old;
  apply_impulse<S, partner, width>(v, arm_a, arm_b, (jn - jn_old) * n + dt, cross(n, dt));
  scatter_moving<S, partner, width>(v, c, velocities);
}

// visit(batch, partner, width) of all batches, colour by colour.
template <class S, class Visit> void for_all_batches(World<S>& world, const Visit& visit) {
  for (const Colour& colour : world.sphere_contacts.colours) {
    for_batches(world, colour.first, colour.last, kMinBatchesForTeam,
                [&](int first, int last, auto width) ATWOOD_INLINED {
                  SphereBatch<S>* batches = world.sphere_contacts.batches.data();
                  if (colour.partner == SpherePartner::moving_sphere)
                    for (int i = first; i < last; ++i)
                      visit(batches[i], std::integral_constant<SpherePartner, SpherePartner::moving_sphere>{}, width);
                  else if (colour.partner == SpherePartner::fixed_sphere)
                    for (int i = first; i < last; ++i)
                      visit(batches[i], std::integral_constant<SpherePartner, SpherePartner::fixed_sphere>{}, width);
                  else
                    for (int i = first; i < last; ++i)
                      visit(batches[i], std::integral_constant<SpherePartner, SpherePartner::plane>{}, width);
                });
  }
}

}  // namespace

template <class S> void prepare_sphere_contacts(World<S>& world, const Preparation<S>& preparation) {
  Row<S>* poses = world.bodies.pose.data();
  Row<S>* velocities = world.bodies.velocity.data();
  for_all_batches(world, [&](SphereBatch<S>& batch, auto partner, auto width)
                             ATWOOD_INLINED { prepare<S, partner(), width()>(batch, preparation, poses, velocities); });
}

template <class S> void solve_sphere_contacts(World<S>& world) {
  Row<S>* velocities = world.bodies.velocity.data();
  for_all_batches(world, [&](SphereBatch<S>& batch, auto partner, auto width) ATWOOD_INLINED {
    if (batch.active) solve<S, partner(), width()>(batch, velocities);
  });
}

#define ATWOOD_SPHERE_CONTACTS(S)                                             \
  template void prepare_sphere_contacts<S>(World<S>&, const Preparation<S>&); \
  template void solve_sphere_contacts<S>(World<S>&);
ATWOOD_SPHERE_CONTACTS(float)
ATWOOD_SPHERE_CONTACTS(double)
#undef ATWOOD_SPHERE_CONTACTS

}  // namespace atwood::stepping
