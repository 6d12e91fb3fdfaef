// What a run tells of its contacts: the mean force of a step, and impacts where a contact begins.
#include "contact/stepping/points.hpp"

namespace atwood::stepping {
namespace {

template <class S> std::array<double, 3> wide(const Vec3<S>& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

// On the surface of a plane or between two bodies, as the last substep had it.
template <class S> Vec3<S> place_of_point(const World<S>& world, const Point<S>& p) {
  return load3(world.bodies.place[p.a].at) + p.arm_a;
}

}  // namespace

template <class S> void clear_sums(World<S>& world) {
  world.told.assign(static_cast<std::size_t>(point_count(world)), Told<S>{});
}

template <class S> void add_sums(World<S>& world) {
  for (int i = 0; i < point_count(world); ++i) {
    if (!used(world, i)) continue;
    const Point<S> p = point_at(world, i);
    if (!(p.impulse[0] > S(0))) continue;
    Told<S>& told = world.told[static_cast<std::size_t>(i)];
    told.size += p.impulse[0];
    told.along += p.impulse[0] * p.n;
    told.across += p.impulse[1] * p.t + p.impulse[2] * p.s;
  }
}

template <class S> void tell_contacts(const World<S>& world, S h_s, Sample& sample) {
  sample.contacts.clear();
  for (int i = 0; i < point_count(world); ++i) {
    if (!used(world, i)) continue;
    const Told<S>& told = world.told[static_cast<std::size_t>(i)];
    if (!(told.size > S(0))) continue;
    const Point<S> p = point_at(world, i);
    const Vec3<S> n = (S(1) / norm(told.along)) * told.along;
    const bool swap = p.a > p.b;
    const S sign = (swap ? S(-1) : S(1));
    ContactSample out;
    out.body_a = swap ? p.b : p.a;
    out.body_b = swap ? p.a : p.b;
    out.x_m = wide(place_of_point(world, p));
    out.normal = wide(sign * n);
    out.gap_m = static_cast<double>(p.gap);
    out.force_n_N = static_cast<double>(told.size / h_s);
    out.force_t_N = wide((sign / h_s) * (told.across - dot(told.across, n) * n));
    sample.contacts.push_back(out);
  }
}

template <class S> void note_approaches(World<S>& world) {
  world.onsets.clear();
  for (int i = 0; i < point_count(world); ++i) {
    if (!used(world, i)) continue;
    const Point<S> p = point_at(world, i);
    // bounces are told where they happen; others have begun before
    if (p.restitution > S(0) || p.impulse[0] > S(0)) continue;
    const S* a = world.bodies.place[p.a].at;
    Vec3<S> n = p.n;
    Vec3<S> arm_a = p.arm_a, arm_b = p.arm_b;
    const Place at = place_of(world, i);
    if (at.point >= 0) {
      arm_a = lane_of(manifolds_at(world, at).point[at.point].r_a, at.lane);
      arm_b = lane_of(manifolds_at(world, at).point[at.point].r_b, at.lane);
    } else if (world.geometry[p.b].kind != ShapeKind::plane) {
      const Vec3<S> d = load3(world.bodies.place[p.b].at) - load3(a);
      const S distance = norm(d);
      if (distance > S(0)) n = (S(1) / distance) * d;
      arm_a = world.geometry[p.a].radius * n;
      arm_b = -world.geometry[p.b].radius * n;
    }
    Point<S> found = p;
    found.arm_a = arm_a;
    found.arm_b = arm_b;
    const S vn = dot(velocity_at(world.bodies, found), n);
    if (vn < -S(2) * norm(world.gravity_W) * world.h_s) world.onsets.push_back({i, vn});
  }
}

template <class S> void tell_onsets(World<S>& world) {
  for (const Onset<S>& onset : world.onsets) {
    const Point<S> p = point_at(world, onset.contact);
    const Told<S>& told = world.told[static_cast<std::size_t>(onset.contact)];
    if (!(told.size > S(0))) continue;
    const bool swap = p.a > p.b;
    const S sign = swap ? S(-1) : S(1);
    const std::array<double, 3> x = wide(place_of_point(world, p)), n = wide(sign * p.n);
    Event event;
    event.t_s = Wide(world.t_s);
    event.kind = EventKind::impact;
    event.body_a = swap ? p.b : p.a;
    event.body_b = swap ? p.a : p.b;
    event.x_m = {x[0], x[1], x[2]};
    event.normal = {n[0], n[1], n[2]};
    event.impulse_n_N_s = Wide(told.size);
    event.impulse_t_N_s = Wide(norm(told.across));
    event.vn_before_m_per_s = Wide(onset.vn_m_per_s);
    event.vn_after_m_per_s = Wide(dot(velocity_at(world.bodies, p), p.n));
    world.observer->event(event);
  }
}

#define ATWOOD_SEEN(S)                                         \
  template void clear_sums<S>(World<S>&);                      \
  template void add_sums<S>(World<S>&);                        \
  template void tell_contacts<S>(const World<S>&, S, Sample&); \
  template void note_approaches<S>(World<S>&);                 \
  template void tell_onsets<S>(World<S>&);
ATWOOD_SEEN(float)
ATWOOD_SEEN(double)
#undef ATWOOD_SEEN

}  // namespace atwood::stepping
