// Energy of what joints and ropes hold, and what they do to conserved quantities.
#pragma once

#include "protocol/sample_series.hpp"
#include "scene/scene.hpp"

namespace atwood::dynamics {

// k (q - rest)^2 / 2 of the joint springs and -T q of the torques that are constant in time [J]. Angles come from the
// poses; how many turns they have is taken from the sample's joints, or else from the start, less than half a turn
// away.
Wide joint_potential_J(const Scene& scene, const SampleView& sample);

// I s'^2 / (2 r^2) of each pulley with the speed s' of its rope at the first body [J].
Wide pulleys_kinetic_J(const Scene& scene, const SampleView& sample);

struct JointProperties {
  bool works = false;  // energy is not conserved: damping, switched or oscillating torques, prescribed motion, stops
                       // that give back less than they take
  bool hold_to_world = false;  // forces from outside the bodies: a joint to the world or to a fixed body, a rope over a
                               // fixed point
};
JointProperties joint_properties(const Scene& scene);

}  // namespace atwood::dynamics
