// Drift off the constraints of lasting contacts.
#include <algorithm>

#include "contact/event/rows.hpp"
#include "math/so3.hpp"

namespace atwood::event {

namespace {

// The loads of least size that do what run.right asks for, and what they do to the bodies.
template <class S> void spread(EventRun<S>& run) {
  for (const int body : run.contact_bodies) run.free_acceleration[body] = {};
  std::fill_n(run.unknown.begin(), run.row_count, S(0));
  std::fill_n(run.weight.begin(), run.row_count, S(1));
  solve_rows(run, run.row_contacts > 1);
  run.has_factors = false;  // of other rows than the rates'
  if (!run.answered) answer_unknowns(run);
}

template <class S> void displace(const EventRun<S>& run, int body, S* y) {
  if (!run.moves[body]) return;
  S* at = y + run.model.offset(body);
  const Twist<S>& by = run.acceleration[body];
  store3(load3(at + kAtPosition) + by.linear, at + kAtPosition);
  if (!run.model.rotates(body) || dot(by.angular, by.angular) == S(0)) return;
  store4(normalised(so3_exp(by.angular) * load4(at + kAtAttitude)), at + kAtAttitude);
}

template <class S> void kick(const EventRun<S>& run, int body, S* y) {
  if (!run.moves[body]) return;
  S* at = y + run.model.offset(body);
  const Twist<S>& by = run.acceleration[body];
  store3(load3(at + kAtVelocity) + by.linear, at + kAtVelocity);
  if (run.model.rotates(body))
    store3(load3(at + kAtBodyRate) + turned_back(run.poses[body], by.angular), at + kAtBodyRate);
}

// Bodies' gaps back to what they are held at, each by the least way.
template <class S> void close_gaps(EventRun<S>& run, S* y) {
  const S near_enough = run.gap_round_off() / S(16);
  for (int turn = 0; turn < 2; ++turn) {
    S worst = S(0);
    for (const Contact<S>& contact : run.contacts)
      if (contact.carries) worst = real::max(worst, real::abs(contact.sight.gap - contact.rest_gap));
    if (worst <= near_enough) return;
    list_unknowns(run, Rows::gaps);
    for (const Contact<S>& contact : run.contacts)
      if (contact.carries) run.right[contact.first_row] = contact.rest_gap - contact.sight.gap;
    spread(run);
    for (const int body : run.contact_bodies) displace(run, body, y);
    see_contacts(run, y);
  }
}

// Is what should be no velocity round-off of the bodies' velocities?
template <class S> bool velocities_agree(const EventRun<S>& run) {
  S worst = S(0), size = S(0);  // squares
  for (const Contact<S>& contact : run.contacts) {
    if (!contact.carries) continue;
    const Feature<S>& feature = run.features[contact.feature];
    const Pose<S>&of = run.poses[feature.knob_body], &on = run.poses[feature.surface_body];
    const Vec3<S>& n = contact.sight.normal;
    const S normal = dot(contact.u, n);
    worst = real::max(worst, contact.mode == Mode::sticks ? dot(contact.u, contact.u) : normal * normal);
    if (contact.turning == Turning::held) {
      const Vec3<S> roll = contact.w - dot(contact.w, n) * n;
      worst = real::max(worst, dot(roll, roll));
    }
    size = real::max(size, dot(of.v, of.v) + dot(on.v, on.v) + dot(of.w, of.w) + dot(on.w, on.w));
  }
  const S round_off = S(4) * real::epsilon<S>();
  return worst <= round_off * round_off * real::max(size, run.speed_scale * run.speed_scale);
}

}  // namespace

template <class S> void project_contacts(EventRun<S>& run, S* y, bool seen) {
  if (run.carrying == 0) return;
  if (!seen) see_contacts(run, y);
  close_gaps(run, y);
  run.sights_at_start = velocities_agree(run);
  if (run.sights_at_start) return;
  list_unknowns(run, Rows::velocities);
  for (const Contact<S>& contact : run.contacts)
    if (contact.carries) project_rows(contact, -contact.u, -contact.w, run.right.data() + contact.first_row);
  spread(run);
  for (const int body : run.contact_bodies) kick(run, body, y);
}

template void project_contacts<float>(EventRun<float>&, float*, bool);
template void project_contacts<double>(EventRun<double>&, double*, bool);
template void project_contacts<long double>(EventRun<long double>&, long double*, bool);

}  // namespace atwood::event
