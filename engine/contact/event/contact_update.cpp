// Active contacts after a segment of a step.
#include "contact/event/contact_update.hpp"

#include <algorithm>

#include "contact/event/contact_forces.hpp"
#include "contact/event/projection.hpp"
#include "contact/event/slip_step.hpp"

namespace atwood::event {

namespace {

// Speeds and directions of slip and rolling after a segment of a step.
template <class S> void renew_directions(const Bodies<S>& bodies, const Proximity<S>& proximity, Contact<S>& contact) {
  const Vec3<S>& n = contact.kinematics.normal;
  if (contact.mode == FrictionMode::slip) {
    const Vec3<S> slip = contact.u - dot(contact.u, n) * n;
    contact.slip_speed = norm(slip);
    const bool moves = contact.slip_speed > bodies.slip_round_off();
    const Vec3<S> direction = moves ? (S(1) / contact.slip_speed) * slip : contact.slip_direction;
    // Just after onset, a direction may change by so much through round-off of the forces.
    const bool same = norm(direction - contact.slip_direction) < S(0x1p-7);
    if (!contact.slip_onset || !same) contact.slip_direction = direction;
  }
  if (contact.rolling == RollingMode::roll) {
    const Vec3<S> roll = contact.w - dot(contact.w, n) * n;
    contact.roll_speed = norm(roll);
    const S radius = proximity.pairs[proximity.candidates[contact.candidate].pair].bounding_radii;
    if (contact.roll_speed * radius > bodies.slip_round_off())
      contact.roll_direction = (S(1) / contact.roll_speed) * roll;
  }
}

}  // namespace

template <class S>
void maintain_contacts(Bodies<S>& bodies, Proximity<S>& proximity, ActiveSet<S>& active,
                       ConstraintSystem<S>& constraints, StateBuffers<S>& states, bool slip_is_resolved) {
  if (active.contacts.empty()) return;
  store_warm_start(active);
  project_contacts(bodies, proximity, active, constraints, states);
  for (Contact<S>& contact : active.contacts) {
    if (!contact.active) continue;
    const bool moved = contact.slip_speed > bodies.slip_round_off();
    renew_directions(bodies, proximity, contact);
    const bool stopped = moved && !contact.at_cone_limit && slip_is_zero(bodies, contact);
    if (slip_is_resolved && stopped) active.active_set_epoch = -1;
  }
  if (active.count == static_cast<int>(active.contacts.size())) return;
  std::erase_if(active.contacts, [&](const Contact<S>& contact) {
    if (contact.active) return false;
    const Candidate<S>& candidate = proximity.candidates[contact.candidate];
    const GapKinematics<S> kinematics = gap_at(bodies, proximity, candidate, states.y.data());
    if (kinematics.gap < contact.target_gap - S(4) * bodies.gap_round_off())
      active.active_set_epoch = -1;  // it closes again: find the active set anew
    if (kinematics.gap <= contact.target_gap + S(4) * bodies.gap_round_off()) return false;
    proximity.candidates[contact.candidate].in_contact = false;
    proximity.pairs[candidate.pair].gaps_segment = -1;  // gaps are not measured while in contact
    return true;
  });
}

template <class S> void release_friction(const Proximity<S>& proximity, ActiveSet<S>& active, Contact<S>& first) {
  const int pair = proximity.candidates[first.candidate].pair;
  const S edge = real::sqrt(real::epsilon<S>());
  for (Contact<S>& contact : active.contacts) {
    if (!contact.active || contact.mode != FrictionMode::stick || proximity.candidates[contact.candidate].pair != pair)
      continue;
    const S friction = norm(contact.friction_N);
    if (&contact != &first && friction < (S(1) - edge) * proximity.pairs[pair].friction * contact.normal_N) continue;
    contact.reached_cone = contact.at_cone_limit = true;
    contact.mode = FrictionMode::slip;
    contact.slip_direction = (S(-1) / friction) * contact.friction_N;
  }
}

#define ATWOOD_CONTACT_UPDATE(S)                                                                                       \
  template void maintain_contacts<S>(Bodies<S>&, Proximity<S>&, ActiveSet<S>&, ConstraintSystem<S>&, StateBuffers<S>&, \
                                     bool);                                                                            \
  template void release_friction<S>(const Proximity<S>&, ActiveSet<S>&, Contact<S>&);
ATWOOD_CONTACT_UPDATE(float)
ATWOOD_CONTACT_UPDATE(double)
ATWOOD_CONTACT_UPDATE(long double)
#undef ATWOOD_CONTACT_UPDATE

}  // namespace atwood::event
