// What a run reports of its contacts: the mean force over a step, and an impact event where a contact without
// restitution begins. (Impacts with restitution are reported where they are resolved, impacts.cpp.)
#include "contact/stepping/contact_points.hpp"

namespace atwood::stepping {
namespace {

template <class S> std::array<double, 3> as_double(const Vec3<S>& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

// The contact point in world axes, as the last substep prepared it.
template <class S> Vec3<S> contact_point_W(const World<S>& world, const SolverPoint<S>& p) {
  return load3(world.bodies.pose[p.a].at) + p.arm_a;
}

}  // namespace

template <class S> void clear_impulse_sums(World<S>& world) {
  world.impulse_sums.assign(static_cast<std::size_t>(point_count(world)), ImpulseSum<S>{});
}

template <class S> void add_impulses_to_sums(World<S>& world) {
  for (int i = 0; i < point_count(world); ++i) {
    if (!is_contact(world, i)) continue;
    const SolverPoint<S> p = solver_point(world, i);
    if (!(p.impulse[0] > S(0))) continue;
    ImpulseSum<S>& sum = world.impulse_sums[static_cast<std::size_t>(i)];
    sum.normal_N_s += p.impulse[0];
    sum.normal_W += p.impulse[0] * p.n;
    sum.tangential_W += p.impulse[1] * p.t + p.impulse[2] * p.s;
  }
}

template <class S> void report_contacts(const World<S>& world, S h_s, Sample& sample) {
  sample.contacts.clear();
  for (int i = 0; i < point_count(world); ++i) {
    if (!is_contact(world, i)) continue;
    const ImpulseSum<S>& sum = world.impulse_sums[static_cast<std::size_t>(i)];
    if (!(sum.normal_N_s > S(0))) continue;
    const SolverPoint<S> p = solver_point(world, i);
    const Vec3<S> n = (S(1) / norm(sum.normal_W)) * sum.normal_W;
    const bool swap = p.a > p.b;
    const S sign = (swap ? S(-1) : S(1));
    ContactSample out;
    out.body_a = swap ? p.b : p.a;
    out.body_b = swap ? p.a : p.b;
    out.x_m = as_double(contact_point_W(world, p));
    out.normal = as_double(sign * n);
    out.gap_m = static_cast<double>(p.gap);
    out.force_n_N = static_cast<double>(sum.normal_N_s / h_s);
    out.force_t_N = as_double((sign / h_s) * (sum.tangential_W - dot(sum.tangential_W, n) * n));
    sample.contacts.push_back(out);
  }
}

template <class S> void record_approach_speeds(World<S>& world) {
  world.approach_speeds.clear();
  for (int i = 0; i < point_count(world); ++i) {
    if (!is_contact(world, i)) continue;
    const SolverPoint<S> p = solver_point(world, i);
    // impacts with restitution are reported elsewhere; a contact that carries an impulse began before
    if (p.restitution > S(0) || p.impulse[0] > S(0)) continue;
    const S* a = world.bodies.pose[p.a].at;
    Vec3<S> n = p.n;
    Vec3<S> arm_a = p.arm_a, arm_b = p.arm_b;
    const ContactAddress at = address_of(world, i);
    if (at.point >= 0) {
      arm_a = lane_vector(manifold_batch(world, at).point[at.point].r_a, at.lane);
      arm_b = lane_vector(manifold_batch(world, at).point[at.point].r_b, at.lane);
    } else if (world.geometry[p.b].kind != ShapeKind::plane) {
      const Vec3<S> d = load3(world.bodies.pose[p.b].at) - load3(a);
      const S distance = norm(d);
      if (distance > S(0)) n = (S(1) / distance) * d;
      arm_a = world.geometry[p.a].radius * n;
      arm_b = -world.geometry[p.b].radius * n;
    }
    SolverPoint<S> at_start = p;
    at_start.arm_a = arm_a;
    at_start.arm_b = arm_b;
    const S vn = dot(relative_velocity(world.bodies, at_start), n);
    if (vn < -S(2) * norm(world.gravity_W) * world.h_s) world.approach_speeds.push_back({i, vn});
  }
}

template <class S> void report_impacts(World<S>& world) {
  for (const ApproachSpeed<S>& approach : world.approach_speeds) {
    const SolverPoint<S> p = solver_point(world, approach.contact);
    const ImpulseSum<S>& sum = world.impulse_sums[static_cast<std::size_t>(approach.contact)];
    if (!(sum.normal_N_s > S(0))) continue;
    const bool swap = p.a > p.b;
    const S sign = swap ? S(-1) : S(1);
    const std::array<double, 3> x = as_double(contact_point_W(world, p)), n = as_double(sign * p.n);
    Event event;
    event.t_s = Wide(world.t_s);
    event.kind = EventKind::impact;
    event.body_a = swap ? p.b : p.a;
    event.body_b = swap ? p.a : p.b;
    event.x_m = {x[0], x[1], x[2]};
    event.normal = {n[0], n[1], n[2]};
    event.impulse_n_N_s = Wide(sum.normal_N_s);
    event.impulse_t_N_s = Wide(norm(sum.tangential_W));
    event.vn_before_m_per_s = Wide(approach.vn_m_per_s);
    event.vn_after_m_per_s = Wide(dot(relative_velocity(world.bodies, p), p.n));
    world.observer->event(event);
  }
}

#define ATWOOD_CONTACT_REPORT(S)                                 \
  template void clear_impulse_sums<S>(World<S>&);                \
  template void add_impulses_to_sums<S>(World<S>&);              \
  template void report_contacts<S>(const World<S>&, S, Sample&); \
  template void record_approach_speeds<S>(World<S>&);            \
  template void report_impacts<S>(World<S>&);
ATWOOD_CONTACT_REPORT(float)
ATWOOD_CONTACT_REPORT(double)
#undef ATWOOD_CONTACT_REPORT

}  // namespace atwood::stepping
