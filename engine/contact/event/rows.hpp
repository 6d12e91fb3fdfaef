// Where contacts act, and how bodies answer to loads there.
#pragma once

#include "contact/event/run.hpp"

namespace atwood::event {

template <class S> Vec3<S> times(const Vec3<S> (&row)[3], const Vec3<S>& v) {
  return {dot(row[0], v), dot(row[1], v), dot(row[2], v)};
}

template <class S> Place<S> place_of(const EventRun<S>& run, const Contact<S>& contact) {
  const Feature<S>& feature = run.features[contact.feature];
  const int k = feature.knob_body, s = feature.surface_body;
  return {{run.moves[k] ? k : -1, run.moves[s] ? s : -1},
          {contact.sight.x - run.poses[k].p, contact.sight.x - run.poses[s].p}};
}

template <class S> Twist<S> load_of(const Vec3<S>& force, const Vec3<S>& couple, const Vec3<S>& arm, S sign) {
  return {sign * force, sign * (cross(arm, force) + couple)};
}
template <class S> Twist<S> answer_of(const Inverse<S>& body, const Twist<S>& load) {
  return {body.mass_per_kg * load.linear, times(body.I_row, load.angular)};
}

// The rows of a contact, of an acceleration between the bodies at its point and an angular one.
template <class S> void project_rows(const Contact<S>& contact, const Vec3<S>& a, const Vec3<S>& alpha, S* values) {
  values[0] = dot(contact.sight.normal, a);
  if (contact.force_rows == 3) {
    values[1] = dot(contact.tangent[0], a);
    values[2] = dot(contact.tangent[1], a);
  }
  if (contact.couple_rows == 2) {
    values[contact.force_rows] = dot(contact.tangent[0], alpha);
    values[contact.force_rows + 1] = dot(contact.tangent[1], alpha);
  }
}

}  // namespace atwood::event
