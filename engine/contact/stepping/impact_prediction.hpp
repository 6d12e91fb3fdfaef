// When the gap of a contact with restitution next closes, under the uniform motion of a substep (impacts.cpp).
#pragma once

#include "contact/stepping/world.hpp"

namespace atwood::stepping {

// One body in the uniform motion of the substep: position at its beginning, velocities, and the velocity
// increment that the motion without contacts adds after the impacts.
template <class S> struct LinearMotion { Vec3<S> p, v, w, dv; };
template <class S> LinearMotion<S> linear_motion(const World<S>& world, int body);

// The next impact of a contact: its time, normal (from a to b) and arms from the centres of mass. The other
// fields are meaningless where none `occurs`.
template <class S> struct PredictedImpact {
  bool occurs = false;
  S t_s{};
  Vec3<S> normal, arm_a, arm_b;
};

// The next impact of a contact from now_s on in the substep; times are relative to its beginning. An impact occurs
// where the gap closes within the substep, at the present velocities or with the velocity increment added, and closes
// faster than that increment. An overlap gives an impact at now_s.
template <class S> PredictedImpact<S> predict_impact(const World<S>& world, int contact, S now_s);

}  // namespace atwood::stepping
