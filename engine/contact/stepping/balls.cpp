// Contacts of balls with balls and planes: normal, arms and inertia need no matrices, and eight are solved at once.
//
// Relative velocity at the point midway, arms r_a = arm_a n and r_b = -arm_b n:
//   u = v_b - v_a - (arm_a w_a + arm_b w_b) x n
// An impulse P on b, -P on a changes u by P_n / mass_n + P_t / mass_t, so normal and tangent are independent of each
// other.
#include "contact/stepping/lanes_of_rows.hpp"
#include "contact/stepping/points.hpp"

namespace atwood::stepping {
namespace {

constexpr int kBatchesWorthATeam = 48;  // some 5 us

// P on b at -arm_b n, -P on a at arm_a n; `turn` is n x P.
template <class S, Side side>
ATWOOD_INLINE void push(Pack<S> (&a)[kLaneCount], Pack<S> (&b)[kLaneCount], const Pack<S>& arm_a, const Pack<S>& arm_b,
                        const Vec3<Pack<S>>& P, const Vec3<Pack<S>>& turn) {
  put3<S>(first3<S>(a) - a[6] * P, a);
  put3<S>(second3<S>(a) - (arm_a * a[7]) * turn, a + 3);
  if constexpr (side == Side::two_balls) {
    put3<S>(first3<S>(b) + b[6] * P, b);
    put3<S>(second3<S>(b) - (arm_b * b[7]) * turn, b + 3);
  }
}

// Sets normal and gap; n stays what it was where the centres coincide.
template <class S, Side side, VectorWidth width>
ATWOOD_INLINE void look(const BallBatch<S>& c, const Pack<S> (&place_a)[kLaneCount],
                        const Pack<S> (&place_b)[kLaneCount], Vec3<Pack<S>>& n, Vec3<Pack<S>>& d, Pack<S>& gap) {
  const Pack<S> radii = load(c.radius_a.lane) + load(c.radius_b.lane);
  n = load_lanes<S>(c.normal);
  if constexpr (side == Side::plane) {
    gap = -dot(n, first3<S>(place_a)) - radii;
    d = (gap + radii) * n;
  } else {
    d = first3<S>(place_b) - first3<S>(place_a);
    const Pack<S> distance = root(WholePack<width>{}, dot(d, d));
    const Pack<S> inverse = S(1) / distance, zero = broadcast(S(0));
    n.x = where_above<S, width>(distance, zero, inverse * d.x, n.x);
    n.y = where_above<S, width>(distance, zero, inverse * d.y, n.y);
    n.z = where_above<S, width>(distance, zero, inverse * d.z, n.z);
    gap = distance - radii;
  }
}

template <class S, Side side, VectorWidth width>
ATWOOD_INLINE void prepare(BallBatch<S>& c, const Preparation<S>& p, Row<S>* places, Row<S>* velocities) {
  Pack<S> place_a[kLaneCount], place_b[kLaneCount], a[kLaneCount], b[kLaneCount];
  gather<S, width>(places, c.a, place_a);
  if constexpr (side != Side::plane) gather<S, width>(places, c.b, place_b);
  else set_zero<S>(place_b);
  Vec3<Pack<S>> n, d;
  Pack<S> gap;
  look<S, side, width>(c, place_a, place_b, n, d, gap);
  const Pack<S> zero = broadcast(S(0));
  gather<S, width>(velocities, c.a, a);
  if constexpr (side == Side::two_balls) gather<S, width>(velocities, c.b, b);
  else set_zero<S>(b);

  const Pack<S> mass_n = load(c.mass_n.lane);
  const Pack<S> overlap = min<S, width>(gap + load(c.slop.lane), zero);
  if (p.push_apart && any_above_zero<S, width>(-overlap)) {
    const Vec3<Pack<S>> push = (p.correction * overlap * mass_n) * n;
    put3<S>(first3<S>(place_a) + a[6] * push, place_a);
    scatter<S, width>(place_a, c.a, c.count, places);
    if constexpr (side == Side::two_balls) {
      put3<S>(first3<S>(place_b) - b[6] * push, place_b);
      scatter<S, width>(place_b, c.b, c.count, places);
    }
  }

  store_lanes<S>(n, c.normal);
  store<S>(gap, c.gap.lane);
  const Pack<S> half = S(0.5) * gap, arm_a = load(c.radius_a.lane) + half;
  const Pack<S> arm_b = side == Side::plane ? zero : load(c.radius_b.lane) + half;
  store<S>(arm_a, c.arm_a.lane);
  store<S>(arm_b, c.arm_b.lane);
  const Pack<S> mobility_t = a[6] + b[6] + arm_a * arm_a * a[7] + arm_b * arm_b * b[7];
  store<S>(where_above<S, width>(mobility_t, zero, S(1) / mobility_t, zero), c.mass_t.lane);
  Pack<S> apart = gap;
  if (p.shifts != nullptr) {
    Pack<S> shift_a[kLaneCount], shift_b[kLaneCount];
    gather<S, width>(p.shifts, c.a, shift_a);
    if constexpr (side == Side::two_balls) gather<S, width>(p.shifts, c.b, shift_b);
    else set_zero<S>(shift_b);
    const Vec3<Pack<S>> shift = first3<S>(shift_b) - first3<S>(shift_a);
    apart = apart + dot(n, shift);
    d = d + shift;
  }
  Pack<S> closing = max<S, width>(apart, zero) * (S(1) / p.h_s);

  Vec3<Pack<S>> t = load_lanes<S>(c.impulse_t);
  Pack<S> jn = load(c.impulse_n.lane);
  // Who only passes by within this substep is no obstacle: |d + u s| at its least, s in [0, h_s].
  const Vec3<Pack<S>> u = first3<S>(b) - first3<S>(a);
  if constexpr (side != Side::plane) {
    const Pack<S> uu = dot(u, u), du = dot(d, u);
    Pack<S> s = where_above<S, width>(uu, zero, -du / uu, zero);
    s = min<S, width>(max<S, width>(s, zero), broadcast(p.h_s));
    const Vec3<Pack<S>> nearest = d + s * u;
    const Pack<S> radii = load(c.radius_a.lane) + load(c.radius_b.lane);
    const Pack<S> misses = where_above<S, width>(dot(nearest, nearest), radii * radii, broadcast(S(1)), zero);
    const Pack<S> passes = where_above<S, width>(apart, zero, where_above<S, width>(jn, zero, zero, misses), zero);
    closing = where_above<S, width>(passes, zero, broadcast(S(1e30)), closing);
  }
  store<S>(closing, c.closing.lane);

  // Neighbours may push it nearer than its own velocity says.
  const Pack<S> un = dot(u, n), radius_a = load(c.radius_a.lane);
  const Pack<S> near = S(0.01) * radius_a + S(2) * p.h_s * max<S, width>(un, -un) - min<S, width>(gap, apart);
  c.active = any_above_zero<S, width>(max<S, width>(near, jn));
  if (!p.warm) {
    store<S>(zero, c.impulse_n.lane);
    store_lanes<S>(Vec3<Pack<S>>{zero, zero, zero}, c.impulse_t);
    return;
  }
  if (!any_above_zero<S, width>(jn)) return;
  t = t - dot(t, n) * n;
  store_lanes<S>(t, c.impulse_t);
  push<S, side>(a, b, arm_a, arm_b, jn * n + t, cross(n, t));
  scatter<S, width>(a, c.a, c.count, velocities);
  if constexpr (side == Side::two_balls) scatter<S, width>(b, c.b, c.count, velocities);
}

// One turn of projected Gauss-Seidel: the normal impulse stays >= 0, the tangential one inside the disc of the round
// cone.
//   P_n <- max(0, P_n - mass_n (u_n + closing))
//   P_t <- project(P_t - mass_t u_t, radius mu P_n)
template <class S, Side side, VectorWidth width> ATWOOD_INLINE void solve(BallBatch<S>& c, Row<S>* velocities) {
  Pack<S> a[kLaneCount], b[kLaneCount];
  gather<S, width>(velocities, c.a, a);
  if constexpr (side == Side::two_balls) gather<S, width>(velocities, c.b, b);
  else set_zero<S>(b);
  const Pack<S> zero = broadcast(S(0)), arm_a = load(c.arm_a.lane), arm_b = load(c.arm_b.lane);
  const Vec3<Pack<S>> n = load_lanes<S>(c.normal);
  const Vec3<Pack<S>> between = first3<S>(b) - first3<S>(a);
  const Pack<S> un = dot(between, n);
  const Pack<S> jn_old = load(c.impulse_n.lane);
  const Pack<S> jn = max<S, width>(jn_old - load(c.mass_n.lane) * (un + load(c.closing.lane)), zero);
  store<S>(jn, c.impulse_n.lane);

  const Vec3<Pack<S>> turning = arm_a * second3<S>(a) + arm_b * second3<S>(b);
  const Vec3<Pack<S>> ut = between - un * n - cross(turning, n);
  const Vec3<Pack<S>> t_old = load_lanes<S>(c.impulse_t);
  Vec3<Pack<S>> t = t_old - load(c.mass_t.lane) * ut;
  const Pack<S> size = root(WholePack<width>{}, dot(t, t)), most = load(c.friction.lane) * jn;
  const Pack<S> factor = where_above<S, width>(size, most, most / size, broadcast(S(1)));
  t = factor * t;
  store_lanes<S>(t, c.impulse_t);

  const Vec3<Pack<S>> dt = t - t_old;
  push<S, side>(a, b, arm_a, arm_b, (jn - jn_old) * n + dt, cross(n, dt));
  scatter<S, width>(a, c.a, c.count, velocities);
  if constexpr (side == Side::two_balls) scatter<S, width>(b, c.b, c.count, velocities);
}

template <class S, class Visit> void for_colours(World<S>& world, const Visit& visit) {
  for (const Colour& colour : world.balls.colours) {
    for_batches(world, colour.first, colour.last, kBatchesWorthATeam,
                [&](int first, int last, auto width) ATWOOD_INLINED {
                  BallBatch<S>* batches = world.balls.batches.data();
                  if (colour.side == Side::two_balls)
                    for (int i = first; i < last; ++i)
                      visit(batches[i], std::integral_constant<Side, Side::two_balls>{}, width);
                  else if (colour.side == Side::fixed_ball)
                    for (int i = first; i < last; ++i)
                      visit(batches[i], std::integral_constant<Side, Side::fixed_ball>{}, width);
                  else
                    for (int i = first; i < last; ++i)
                      visit(batches[i], std::integral_constant<Side, Side::plane>{}, width);
                });
  }
}

}  // namespace

template <class S> void prepare_balls(World<S>& world, S h_s, bool push_apart, bool warm) {
  const Preparation<S> p{h_s, S(world.options.correction), push_apart, warm,
                         world.bounces ? world.bodies.shift.data() : nullptr};
  Row<S>* places = world.bodies.place.data();
  Row<S>* velocities = world.bodies.velocity.data();
  for_colours(world, [&](BallBatch<S>& batch, auto side, auto width)
                         ATWOOD_INLINED { prepare<S, side(), width()>(batch, p, places, velocities); });
}

template <class S> void solve_balls(World<S>& world) {
  Row<S>* velocities = world.bodies.velocity.data();
  for_colours(world, [&](BallBatch<S>& batch, auto side, auto width) ATWOOD_INLINED {
    if (batch.active) solve<S, side(), width()>(batch, velocities);
  });
}

#define ATWOOD_BALLS(S)                                     \
  template void prepare_balls<S>(World<S>&, S, bool, bool); \
  template void solve_balls<S>(World<S>&);
ATWOOD_BALLS(float)
ATWOOD_BALLS(double)
#undef ATWOOD_BALLS

}  // namespace atwood::stepping
