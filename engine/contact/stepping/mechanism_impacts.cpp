// Impacts of mechanisms: one impulse at a contact or along a joint's coordinate, and at the same instant the
// impulses of all joints, so that no joint's rate changes.
#include <algorithm>

#include "contact/slip_path.hpp"
#include "contact/stepping/contact_points.hpp"
#include "contact/stepping/mechanisms.hpp"

namespace atwood::stepping {
namespace {

// Factors the rows at the poses t_s after the beginning of the substep, takes the present rates as the targets that
// satisfy_joints() restores, and stores velocities (tied->velocity_before_impact) and the gap rates of the stops from
// before the impact for end_impact().
template <class S> void begin_impact(World<S>& world, Mechanism<S>& mechanism, S t_s) {
  factor_rows(world, mechanism, t_s, /*compliant=*/false);
  for (TiedRow<S>& row : mechanism.rows) row.target_rate = rate_of(world, row);
  for (const int body : mechanism.bodies)
    world.tied->velocity_before_impact[static_cast<std::size_t>(body)] =
        world.bodies.velocity[static_cast<std::size_t>(body)];
  for (const int s : mechanism.stops) {
    StopConstraint<S>& stop = world.tied->stops[static_cast<std::size_t>(s)];
    set_stop_row(world, stop, t_s);
    stop.rate_before = rate_of(world, stop.row);
  }
}

// After an impulse at t_s: applies the impulses of the joints, adds them to the reactions, and shifts positions
// (impact_shift) and the gaps of stops as if the new velocities had acted since the beginning of the substep.
template <class S> void end_impact(World<S>& world, Mechanism<S>& mechanism, S t_s) {
  satisfy_joints(world, mechanism);
  add_reactions(world, mechanism, t_s);
  for (const int body : mechanism.bodies) {
    const auto i = static_cast<std::size_t>(body);
    if (!world.bodies.moves[i]) continue;
    const Row<S>&before = world.tied->velocity_before_impact[i], &after = world.bodies.velocity[i];
    for (int c = 0; c < 6; ++c) world.bodies.impact_shift[i].at[c] -= t_s * (after.at[c] - before.at[c]);
  }
  for (const int s : mechanism.stops) {
    StopConstraint<S>& stop = world.tied->stops[static_cast<std::size_t>(s)];
    stop.gap -= t_s * (rate_of(world, stop.row) - stop.rate_before);
  }
}

template <class S> Mechanism<S>* mechanism_of(World<S>& world, int body) {
  const int index = world.tied->mechanism_of[static_cast<std::size_t>(body)];
  return index < 0 ? nullptr : &world.tied->mechanisms[static_cast<std::size_t>(index)];
}

// The gap rate that a substep's velocity increments, with the impulses of the joints, give at this stop. Works on the
// mechanism itself: its velocities are restored; its rows and their factors, tied->velocity_before_impact and the
// rate_before of its stops are overwritten.
template <class S> S gap_rate_increment(World<S>& world, Mechanism<S>& mechanism, const StopConstraint<S>& stop) {
  begin_impact(world, mechanism, S(0));
  auto& velocity = world.bodies.velocity;
  for (const int body : mechanism.bodies)
    velocity[static_cast<std::size_t>(body)] = world.bodies.velocity_increment[static_cast<std::size_t>(body)];
  for (TiedRow<S>& row : mechanism.rows) row.target_rate = S(0);
  satisfy_joints(world, mechanism);
  const S rate = rate_of(world, stop.row);
  for (TiedRow<S>& row : mechanism.rows) row.impulse = S(0);
  for (const int body : mechanism.bodies)
    velocity[static_cast<std::size_t>(body)] = world.tied->velocity_before_impact[static_cast<std::size_t>(body)];
  return rate;
}

template <class S>
void report_stop(const World<S>& world, const StopConstraint<S>& stop, S t_s, S impulse, S before, S after) {
  if (world.observer == nullptr || !world.observer->event) return;
  const Joint& joint = world.scene->joints[static_cast<std::size_t>(stop.joint)];
  const TiedBody<S> child = tied_body(world, joint.child, t_s);
  const Vec3<S> axis = narrow3<S>(joint.axis_body), n = rotate(child.q_WB, (stop.side / norm(axis)) * axis),
                x = child.p_WB + rotate(child.q_WB, narrow3<S>(joint.anchors_body_m[1]));
  Event event;
  event.t_s = Wide(world.t_s) + Wide(t_s);
  event.kind = EventKind::impact;
  event.body_a = joint.parent;
  event.body_b = joint.child;
  event.x_m = {Wide(x.x), Wide(x.y), Wide(x.z)};
  event.normal = {Wide(n.x), Wide(n.y), Wide(n.z)};
  event.impulse_n_N_s = Wide(impulse);
  event.vn_before_m_per_s = Wide(before);
  event.vn_after_m_per_s = Wide(after);
  world.observer->event(event);
}

// The stop with restitution that the mechanism reaches first in [now_s, until_s], and when (t_s); -1: none. Approaches
// that close less than the round-off of the gap in a substep, or are slower than the change of the gap rate in a
// substep, are left to the velocity solver. Overwrites the rows of the stops.
template <class S> int next_stop(World<S>& world, Mechanism<S>& mechanism, S now_s, S until_s, S& t_s) {
  int next = -1;
  for (const int s : mechanism.stops) {
    StopConstraint<S>& stop = world.tied->stops[static_cast<std::size_t>(s)];
    if (!(stop.restitution > S(0))) continue;
    set_stop_row(world, stop, S(0));
    const S rate = rate_of(world, stop.row);
    if (!(-rate * world.sub_s > stop.round_off)) continue;
    // the coordinate moves uniformly between impacts: stop.gap is where it would have started from
    const S reached = real::max(stop.gap / -rate, now_s);
    if (!(reached <= until_s) || (next >= 0 && !(reached < t_s))) continue;
    if (!(-rate > real::abs(gap_rate_increment(world, mechanism, stop)))) continue;
    set_stop_row(world, stop, reached);
    if (!(rate_of(world, stop.row) < S(0)) || !(squared(stop_response(world, stop)) > S(0))) continue;
    next = s;
    t_s = reached;
  }
  return next;
}

template <class S> struct ReachedStop {
  Mechanism<S>* mechanism = nullptr;  // null: none is reached
  int stop = -1;
  S t_s{};
};
template <class S> ReachedStop<S> first_stop(World<S>& world, S now_s, S until_s) {
  ReachedStop<S> first;
  for (Mechanism<S>& mechanism : world.tied->mechanisms) {
    S reached_s{};
    const int stop = next_stop(world, mechanism, now_s, until_s, reached_s);
    if (stop >= 0 && (first.mechanism == nullptr || reached_s < first.t_s)) first = {&mechanism, stop, reached_s};
  }
  return first;
}

}  // namespace

template <class S> bool reaches_stop(World<S>& world, S now_s, S until_s) {
  return first_stop(world, now_s, until_s).mechanism != nullptr;
}

template <class S> const Mechanism<S>* resolve_stop_impact(World<S>& world, S& now_s, S until_s) {
  TiedBodies<S>& tied = *world.tied;
  const auto [mechanism, first, t_s] = first_stop(world, now_s, until_s);
  if (mechanism == nullptr) return nullptr;
  now_s = t_s;
  StopConstraint<S>& stop = tied.stops[static_cast<std::size_t>(first)];
  begin_impact(world, *mechanism, t_s);
  const S impulse = -(S(1) + stop.restitution) * stop.rate_before / squared(stop_response(world, stop));
  apply_row(world, stop.row, impulse);
  end_impact(world, *mechanism, t_s);
  tied.joints[static_cast<std::size_t>(stop.joint)].stop += stop.side * impulse;
  report_stop(world, stop, t_s, impulse, stop.rate_before, rate_of(world, stop.row));
  return mechanism;
}

template <class S>
Impulse<S> collide_tied(World<S>& world, int a, int b, const ImpactLaw<S>& law, const Vec3<S>& normal,
                        const Vec3<S>& arm_a, const Vec3<S>& arm_b, S t_s, Vec3<S>& impulse_W) {
  TiedBodies<S>& tied = *world.tied;
  BodyRows<S>& bodies = world.bodies;
  Mechanism<S>*of_a = mechanism_of(world, a), *of_b = mechanism_of(world, b);
  if (of_a != nullptr) begin_impact(world, *of_a, t_s);
  if (of_b != nullptr && of_b != of_a) begin_impact(world, *of_b, t_s);
  const int pair[2] = {a, b};
  const Vec3<S> arm[2] = {arm_a, arm_b};
  const auto velocity_of = [&](int k) {
    const S* v = bodies.velocity[static_cast<std::size_t>(pair[k])].at;
    return load3(v) + cross(load3(v + 3), arm[k]);
  };
  Impulse<S> impulse;
  impulse_W = {};
  const Vec3<S> before = velocity_of(1) - velocity_of(0);
  impulse.vn_before_m_per_s = impulse.vn_after_m_per_s = dot(before, normal);
  if (!(impulse.vn_before_m_per_s < S(0))) return impulse;
  const Vec3<S> slip = before - impulse.vn_before_m_per_s * normal;
  const S slip_speed = norm(slip);
  const Vec3<S> along = slip_speed > S(0) ? (S(1) / slip_speed) * slip : unit_tangent(normal);
  const Vec3<S> axis[3] = {along, cross(normal, along), normal};
  // K: change of the relative velocity at the point per unit impulse, in the axes (slip, across, normal). A body
  // without joints adds J M^-1 J^T, a mechanism the scalar products of its responses.
  S K[3][3] = {};
  for (int k = 0; k < 2; ++k) {
    if (is_tied(world, pair[k]) || !bodies.moves[static_cast<std::size_t>(pair[k])]) continue;
    const Row<S>& inertia = bodies.inertia[static_cast<std::size_t>(pair[k])];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        K[i][j] += inertia.at[6] * dot(axis[i], axis[j]) +
                   dot(cross(arm[k], axis[i]), apply_inverse_inertia(inertia, cross(arm[k], axis[j])));
  }
  for (Mechanism<S>* mechanism : {of_a, of_b == of_a ? nullptr : of_b}) {
    if (mechanism == nullptr) continue;
    TiedResponse<S> response[3];
    for (int i = 0; i < 3; ++i) {
      response[i].mechanism = static_cast<int>(mechanism - tied.mechanisms.data());
      response[i].z.assign(mechanism->z.size(), S(0));
      for (int k = 0; k < 2; ++k) {
        if (mechanism_of(world, pair[k]) != mechanism) continue;
        const Vec3<S> force = (k == 0 ? S(-1) : S(1)) * axis[i];
        add_to_response(world, pair[k], force, cross(arm[k], force), response[i]);
      }
      project_response(world, response[i]);
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (std::size_t c = 0; c < response[i].z.size(); ++c) K[i][j] += response[i].z[c] * response[j].z[c];
  }
  if (!(K[2][2] > S(0))) return impulse;  // the joints hold the point along the normal
  // where joints leave the point no slip in some direction, it is given a little, so that the slip's path is defined
  const S trace = K[0][0] + K[1][1] + K[2][2], tangential = K[0][0] * K[1][1] - K[0][1] * K[1][0];
  if (!(tangential > S(1e-6) * trace * trace))
    for (int i = 0; i < 2; ++i) K[i][i] += real::sqrt(real::epsilon<S>()) * trace;
  S J[3] = {S(0), S(0), -(S(1) + law.restitution) * impulse.vn_before_m_per_s / K[2][2]};
  if (law.friction > S(0)) {
    const S u0[3] = {slip_speed, S(0), impulse.vn_before_m_per_s};
    const SlipPath<S> path = slip_path(law, K, u0);
    std::copy(path.impulse_N_s, path.impulse_N_s + 3, J);
    add_solve(path.solve, impulse);
  }
  impulse_W = J[0] * axis[0] + J[1] * axis[1] + J[2] * axis[2];
  impulse.normal_N_s = J[2];
  impulse.tangential_N_s = real::sqrt(J[0] * J[0] + J[1] * J[1]);
  for (int k = 0; k < 2; ++k) {
    const auto i = static_cast<std::size_t>(pair[k]);
    if (!bodies.moves[i]) continue;
    const Vec3<S> P = (k == 0 ? S(-1) : S(1)) * impulse_W;
    const Vec3<S> dv = bodies.inertia[i].at[6] * P, dw = apply_inverse_inertia(bodies.inertia[i], cross(arm[k], P));
    S* v = bodies.velocity[i].at;
    store3(load3(v) + dv, v);
    store3(load3(v + 3) + dw, v + 3);
    if (is_tied(world, pair[k])) continue;
    S* shift = bodies.impact_shift[i].at;
    store3(load3(shift) - t_s * dv, shift);
    store3(load3(shift + 3) - t_s * dw, shift + 3);
  }
  if (of_a != nullptr) end_impact(world, *of_a, t_s);
  if (of_b != nullptr && of_b != of_a) end_impact(world, *of_b, t_s);
  impulse.vn_after_m_per_s = dot(velocity_of(1) - velocity_of(0), normal);
  return impulse;
}

#define ATWOOD_MECHANISM_IMPACTS(S)                                                                             \
  template bool reaches_stop<S>(World<S>&, S, S);                                                               \
  template const Mechanism<S>* resolve_stop_impact<S>(World<S>&, S&, S);                                        \
  template Impulse<S> collide_tied<S>(World<S>&, int, int, const ImpactLaw<S>&, const Vec3<S>&, const Vec3<S>&, \
                                      const Vec3<S>&, S, Vec3<S>&);
ATWOOD_MECHANISM_IMPACTS(float)
ATWOOD_MECHANISM_IMPACTS(double)
#undef ATWOOD_MECHANISM_IMPACTS

}  // namespace atwood::stepping
