// Contacts of any shapes, a manifold a lane, its points one after another while both bodies stand in registers.
//
// With arms r_a, r_b to the point, an impulse P on b and -P on a changes the relative velocity there by K P,
//   K = (1/m_a + 1/m_b) 1 - [r_a] I_a^-1 [r_a] - [r_b] I_b^-1 [r_b].
#include "contact/stepping/lanes_of_rows.hpp"
#include "contact/stepping/points.hpp"

namespace atwood::stepping {
namespace {

constexpr int kBatchesWorthATeam = 16;

// v w of the velocity row, I^-1 and 1/m of the inertia row.
template <class S> struct Partner {
  Pack<S> velocity[kLaneCount], inertia[kLaneCount];
  ATWOOD_INLINE Vec3<Pack<S>> v() const { return first3<S>(velocity); }
  ATWOOD_INLINE Vec3<Pack<S>> w() const { return second3<S>(velocity); }
  ATWOOD_INLINE const Pack<S>& inverse_mass() const { return inertia[6]; }
  ATWOOD_INLINE Vec3<Pack<S>> turn(const Vec3<Pack<S>>& L) const {
    return {inertia[0] * L.x + inertia[1] * L.y + inertia[2] * L.z,
            inertia[1] * L.x + inertia[3] * L.y + inertia[4] * L.z,
            inertia[2] * L.x + inertia[4] * L.y + inertia[5] * L.z};
  }
  ATWOOD_INLINE void push(const Vec3<Pack<S>>& arm, const Vec3<Pack<S>>& P) {
    put3<S>(v() + inverse_mass() * P, velocity);
    put3<S>(w() + turn(cross(arm, P)), velocity + 3);
  }
};

template <class S, VectorWidth width>
ATWOOD_INLINE void read(const ManifoldBatch<S>& c, const Row<S>* velocities, const Row<S>* inertias, Partner<S>& a,
                        Partner<S>& b) {
  gather<S, width>(velocities, c.a, a.velocity);
  gather<S, width>(velocities, c.b, b.velocity);
  gather<S, width>(inertias, c.a, a.inertia);
  gather<S, width>(inertias, c.b, b.inertia);
}

// Only rows of bodies that move: what is fixed may stand in many lanes, and of many threads.
template <class S, VectorWidth width>
ATWOOD_INLINE void write(const ManifoldBatch<S>& c, const unsigned char* moves, Pack<S> (&a)[kLaneCount],
                         Pack<S> (&b)[kLaneCount], Row<S>* rows) {
  scatter<S, width>(a, c.a, c.count, rows);
  transpose<S, width>(b);
  for (int k = 0; k < kLaneCount; ++k)
    if (k < c.count && moves[c.b[k]]) store<S>(b[k], rows[c.b[k]].at);
}

template <class S, VectorWidth width> ATWOOD_INLINE Pack<S> inverse_or_none(const Pack<S>& a) {
  return where_above<S, width>(a, broadcast(S(0)), S(1) / a, broadcast(S(0)));
}

template <class S, VectorWidth width>
ATWOOD_INLINE void weigh(ManifoldBatch<S>& c, const Row<S>* velocities, const Row<S>* inertias) {
  Partner<S> a, b;
  read<S, width>(c, velocities, inertias, a, b);
  const Vec3<Pack<S>> n = load_lanes<S>(c.normal), t = load_lanes<S>(c.tangent), s = cross(n, t);
  const Pack<S> linear = a.inverse_mass() + b.inverse_mass();
  for (int i = 0; i < c.points; ++i) {
    ManifoldPoint<S>& point = c.point[i];
    const Vec3<Pack<S>> r_a = load_lanes<S>(point.r_a), r_b = load_lanes<S>(point.r_b);
    const auto if_used = [&](const Pack<S>& x) ATWOOD_INLINED {
      return where_above<S, width>(broadcast(S(1e29)), load(point.gap_found.lane), x, broadcast(S(0)));
    };
    const Vec3<Pack<S>> an = cross(r_a, n), bn = cross(r_b, n), at = cross(r_a, t), bt = cross(r_b, t),
                        as = cross(r_a, s), bs = cross(r_b, s);
    const Vec3<Pack<S>> Iat = a.turn(at), Ibt = b.turn(bt);
    const Pack<S> nn = linear + dot(an, a.turn(an)) + dot(bn, b.turn(bn));
    const Pack<S> tt = linear + dot(at, Iat) + dot(bt, Ibt), ts = dot(as, Iat) + dot(bs, Ibt);
    const Pack<S> ss = linear + dot(as, a.turn(as)) + dot(bs, b.turn(bs));
    store<S>(if_used(inverse_or_none<S, width>(nn)), point.mass_n.lane);
    const Pack<S> by_determinant = inverse_or_none<S, width>(tt * ss - ts * ts);
    store<S>(if_used(by_determinant * ss), point.mass_t[0].lane);
    store<S>(if_used(-by_determinant * ts), point.mass_t[1].lane);
    store<S>(if_used(by_determinant * tt), point.mass_t[2].lane);
    const Pack<S> half = S(0.5) * (tt - ss);
    const Pack<S> larger = S(0.5) * (tt + ss) + root(WholePack<width>{}, half * half + ts * ts);
    store<S>(if_used(inverse_or_none<S, width>(larger)), point.step_t.lane);
  }
}

template <class S, VectorWidth width>
ATWOOD_INLINE void prepare(ManifoldBatch<S>& c, const Preparation<S>& p, Row<S>* places, Row<S>* velocities,
                           const Row<S>* inertias, const unsigned char* moves) {
  Partner<S> a, b;
  read<S, width>(c, velocities, inertias, a, b);
  Pack<S> place_a[kLaneCount], place_b[kLaneCount];
  gather<S, width>(places, c.a, place_a);
  gather<S, width>(places, c.b, place_b);
  const Vec3<Pack<S>> n = load_lanes<S>(c.normal), t = load_lanes<S>(c.tangent), s = cross(n, t);
  const Pack<S> zero = broadcast(S(0));
  const Outline<Pack<S>> outline_a{load_lanes<S>(c.axis_a), load(c.round_a.lane)};
  const Outline<Pack<S>> outline_b{load_lanes<S>(c.axis_b), load(c.round_b.lane)};
  const Vec3<Pack<S>> turned_a = load_lanes<S>(c.turned_a), turned_b = load_lanes<S>(c.turned_b);
  const Pack<S> lean = load(c.lean.lane);
  Pack<S> shift_a[kLaneCount], shift_b[kLaneCount];
  if (p.shifts != nullptr) {
    gather<S, width>(p.shifts, c.a, shift_a);
    gather<S, width>(p.shifts, c.b, shift_b);
  }
  bool pushed = false, warmed = false;
  for (int i = 0; i < c.points; ++i) {
    ManifoldPoint<S>& point = c.point[i];
    const auto [x_a, x_b, gap] =
        moved_point<S, Pack<S>>(n, load_lanes<S>(point.r_a), load_lanes<S>(point.r_b), load(point.gap_found.lane),
                                first3<S>(place_b) - first3<S>(place_a), second3<S>(place_a) - turned_a,
                                second3<S>(place_b) - turned_b, outline_a, outline_b, lean);
    const auto if_used = [&](const Pack<S>& x) ATWOOD_INLINED {
      return where_above<S, width>(broadcast(S(1e29)), load(point.gap_found.lane), x, broadcast(S(0)));
    };
    const Pack<S> overlap = if_used(min<S, width>(gap + load(c.slop.lane), zero));
    if (p.push_apart && any_above_zero<S, width>(-overlap)) {
      pushed = true;
      const Vec3<Pack<S>> push = (p.correction * overlap * load(point.mass_n.lane)) * n;  // on a
      put3<S>(first3<S>(place_a) + a.inverse_mass() * push, place_a);
      put3<S>(second3<S>(place_a) + a.turn(cross(x_a, push)), place_a + 3);
      put3<S>(first3<S>(place_b) - b.inverse_mass() * push, place_b);
      put3<S>(second3<S>(place_b) - b.turn(cross(x_b, push)), place_b + 3);
    }
    store<S>(gap, point.gap.lane);
    Pack<S> apart = gap;
    if (p.shifts != nullptr)
      apart = apart + dot(n, (first3<S>(shift_b) + cross(second3<S>(shift_b), x_b)) -
                                 (first3<S>(shift_a) + cross(second3<S>(shift_a), x_a)));
    // Of what carries, a gap of round-off is none: at rest the impulses of the last substep then solve this one as they
    // are.
    const Pack<S> carried = load(point.impulse_n.lane), round_off = S(1e-6) * load(c.slop.lane);
    const Pack<S> room = apart - where_above<S, width>(carried, zero, round_off, zero);
    store<S>(max<S, width>(room, zero) * (S(1) / p.h_s), point.closing.lane);
    store_lanes<S>(x_a, point.arm_a);
    store_lanes<S>(x_b, point.arm_b);
    if (!p.warm) {
      store<S>(zero, point.impulse_n.lane);
      store<S>(zero, point.impulse_t[0].lane);
      store<S>(zero, point.impulse_t[1].lane);
      continue;
    }
    const Pack<S> jn = load(point.impulse_n.lane);
    if (!any_above_zero<S, width>(jn)) continue;
    warmed = true;
    const Vec3<Pack<S>> P = jn * n + load(point.impulse_t[0].lane) * t + load(point.impulse_t[1].lane) * s;
    a.push(x_a, -P);
    b.push(x_b, P);
  }
  if (pushed) write<S, width>(c, moves, place_a, place_b, places);
  if (warmed) write<S, width>(c, moves, a.velocity, b.velocity, velocities);
}

// The normal impulse first, then the tangential pair: if what would stop the slip lies inside the disc of the round
// cone, that; else a step of projected gradient, whose fixed point has friction straight against the slip whatever K
// is.
template <class S, VectorWidth width>
ATWOOD_INLINE void solve(ManifoldBatch<S>& c, Row<S>* velocities, const Row<S>* inertias, const unsigned char* moves) {
  Partner<S> a, b;
  read<S, width>(c, velocities, inertias, a, b);
  const Vec3<Pack<S>> n = load_lanes<S>(c.normal), t = load_lanes<S>(c.tangent), s = cross(n, t);
  const Pack<S> zero = broadcast(S(0)), mu = load(c.friction.lane);
  for (int i = 0; i < c.points; ++i) {
    ManifoldPoint<S>& point = c.point[i];
    const Vec3<Pack<S>> r_a = load_lanes<S>(point.arm_a), r_b = load_lanes<S>(point.arm_b);
    Vec3<Pack<S>> u = (b.v() + cross(b.w(), r_b)) - (a.v() + cross(a.w(), r_a));
    const Pack<S> jn_old = load(point.impulse_n.lane);
    const Pack<S> jn = max<S, width>(jn_old - load(point.mass_n.lane) * (dot(u, n) + load(point.closing.lane)), zero);
    store<S>(jn, point.impulse_n.lane);
    const Vec3<Pack<S>> dn = (jn - jn_old) * n;
    a.push(r_a, -dn);
    b.push(r_b, dn);

    u = (b.v() + cross(b.w(), r_b)) - (a.v() + cross(a.w(), r_a));
    Pack<S> ut = dot(u, t), us = dot(u, s);
    if (c.slips) {
      ut += load(c.slip[i][0].lane);
      us += load(c.slip[i][1].lane);
    }
    const Pack<S> most = mu * jn;
    const Pack<S> t_old = load(point.impulse_t[0].lane), s_old = load(point.impulse_t[1].lane);
    const Pack<S> m11 = load(point.mass_t[0].lane), m12 = load(point.mass_t[1].lane), m22 = load(point.mass_t[2].lane);
    const Pack<S> stick_t = t_old - (m11 * ut + m12 * us), stick_s = s_old - (m12 * ut + m22 * us);
    const Pack<S> wanted2 = stick_t * stick_t + stick_s * stick_s, most2 = most * most;
    const Pack<S> step = load(point.step_t.lane);
    const Pack<S> slip_t = t_old - step * ut, slip_s = s_old - step * us;
    const Pack<S> size = root(WholePack<width>{}, slip_t * slip_t + slip_s * slip_s);
    const Pack<S> factor = where_above<S, width>(size, most, most / size, broadcast(S(1)));
    const Pack<S> jt = where_above<S, width>(wanted2, most2, factor * slip_t, stick_t);
    const Pack<S> js = where_above<S, width>(wanted2, most2, factor * slip_s, stick_s);
    store<S>(jt, point.impulse_t[0].lane);
    store<S>(js, point.impulse_t[1].lane);
    const Vec3<Pack<S>> dt = (jt - t_old) * t + (js - s_old) * s;
    a.push(r_a, -dt);
    b.push(r_b, dt);
  }
  write<S, width>(c, moves, a.velocity, b.velocity, velocities);
}

template <class S, class Visit> void for_colours(World<S>& world, const Visit& visit) {
  for (const Colour& colour : world.manifold_batches.colours)
    for_batches(world, colour.first, colour.last, kBatchesWorthATeam,
                [&](int first, int last, auto width) ATWOOD_INLINED {
                  ManifoldBatch<S>* batches = world.manifold_batches.batches.data();
                  for (int i = first; i < last; ++i) visit(batches[i], width);
                });
}

}  // namespace

template <class S> void weigh_manifolds(World<S>& world) {
  const Row<S>*velocities = world.bodies.velocity.data(), *inertias = world.bodies.inertia.data();
  for_colours(world, [&](ManifoldBatch<S>& batch, auto width)
                         ATWOOD_INLINED { weigh<S, width()>(batch, velocities, inertias); });
}

template <class S> void weigh_batch(World<S>& world, ManifoldBatch<S>& batch) {
  weigh<S, VectorWidth::narrow>(batch, world.bodies.velocity.data(), world.bodies.inertia.data());
}

template <class S> void prepare_manifolds(World<S>& world, S h_s, bool push_apart, bool warm) {
  const Preparation<S> p{h_s, S(world.options.correction), push_apart, warm,
                         world.bounces ? world.bodies.shift.data() : nullptr};
  Row<S>*places = world.bodies.place.data(), *velocities = world.bodies.velocity.data();
  const Row<S>* inertias = world.bodies.inertia.data();
  const unsigned char* moves = world.bodies.moves.data();
  for_colours(world, [&](ManifoldBatch<S>& batch, auto width)
                         ATWOOD_INLINED { prepare<S, width()>(batch, p, places, velocities, inertias, moves); });
}

template <class S> void solve_manifolds(World<S>& world) {
  Row<S>* velocities = world.bodies.velocity.data();
  const Row<S>* inertias = world.bodies.inertia.data();
  const unsigned char* moves = world.bodies.moves.data();
  for_colours(world, [&](ManifoldBatch<S>& batch, auto width)
                         ATWOOD_INLINED { solve<S, width()>(batch, velocities, inertias, moves); });
}

#define ATWOOD_MANIFOLDS(S)                                     \
  template void weigh_manifolds<S>(World<S>&);                  \
  template void weigh_batch<S>(World<S>&, ManifoldBatch<S>&);   \
  template void prepare_manifolds<S>(World<S>&, S, bool, bool); \
  template void solve_manifolds<S>(World<S>&);
ATWOOD_MANIFOLDS(float)
ATWOOD_MANIFOLDS(double)
#undef ATWOOD_MANIFOLDS

}  // namespace atwood::stepping
