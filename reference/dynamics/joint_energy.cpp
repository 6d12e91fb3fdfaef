#include "dynamics/joint_energy.hpp"

#include <algorithm>

#include "dynamics/arithmetic.hpp"
#include "dynamics/joint_poses.hpp"

namespace atwood::dynamics {
namespace {

bool is_constant(const JointTorque& torque) { return torque.angular_frequency_rad_per_s == 0 && torque.on_s.empty(); }

// The coordinate from the poses, in the turn that the sample's own joint names.
Wide coordinate(const Scene& scene, const SampleView& sample, int joint, int i) {
  const auto j = static_cast<std::size_t>(joint);
  const Wide from_poses = joint_pose(scene, joint, sample).q[i];
  if (!is_angle(scene.joints[j].kind, i)) return from_poses;
  const bool reported = j < sample.joints.size() && sample.joints[j].q[i] == sample.joints[j].q[i];
  const Wide near = reported ? sample.joints[j].q[i] : Wide(scene.joints[j].coordinates[i]);
  static const Wide turn = 2 * acosq(-1);
  return from_poses + turn * floorq((near - from_poses) / turn + Wide(0.5));
}

bool held(const Scene& scene, int body) { return body < 0 || scene.bodies[static_cast<std::size_t>(body)].fixed; }

}  // namespace

Wide joint_potential_J(const Scene& scene, const SampleView& sample) {
  Wide sum = 0;
  for (const JointForce& force : scene.joint_forces) {
    if (const auto* spring = std::get_if<JointSpring>(&force)) {
      if (spring->stiffness == 0) continue;
      const Wide stretch = coordinate(scene, sample, spring->joint, spring->coordinate) - Wide(spring->rest);
      sum += Wide(spring->stiffness) * stretch * stretch / 2;
    } else if (const auto* torque = std::get_if<JointTorque>(&force); torque && is_constant(*torque)) {
      sum -= Wide(torque->torque) * cos(Wide(torque->phase_rad)) *
             coordinate(scene, sample, torque->joint, torque->coordinate);
    }
  }
  return sum;
}

Wide pulleys_kinetic_J(const Scene& scene, const SampleView& sample) {
  Wide sum = 0;
  for (const Rope& rope : scene.ropes) {
    Wide inertia = 0;  // of the rope's motion [kg]
    for (const Pulley& pulley : rope.over)
      if (pulley.radius_m > 0) inertia += Wide(pulley.inertia_kg_m2) / (Wide(pulley.radius_m) * Wide(pulley.radius_m));
    if (inertia == 0) continue;
    const Wide speed = rope_speed_m_per_s(scene, rope, sample);
    sum += inertia * speed * speed / 2;
  }
  return sum;
}

JointProperties joint_properties(const Scene& scene) {
  JointProperties p;
  for (const Joint& joint : scene.joints) {
    p.works |= joint.driven_rate.has_value() && *joint.driven_rate != 0;
    p.works |= joint.limits.has_value() && joint.limits->restitution != 1;
    p.hold_to_world |= held(scene, joint.parent) || held(scene, joint.child);
  }
  for (const Rope& rope : scene.ropes)
    p.hold_to_world |= !rope.over.empty() || held(scene, rope.bodies[0]) || held(scene, rope.bodies[1]);
  for (const JointForce& force : scene.joint_forces) {
    if (const auto* spring = std::get_if<JointSpring>(&force)) p.works |= spring->damping != 0;
    else p.works |= !is_constant(std::get<JointTorque>(force));
  }
  const bool jointed = !scene.joints.empty() || !scene.ropes.empty();
  // A fixed body that moves as prescribed does work on what is tied to it.
  for (const Body& body : scene.bodies)
    p.works |=
        jointed && body.fixed && (body.velocity_m_per_s != Real3{} || body.angular_velocity_body_rad_per_s != Real3{});
  return p;
}

}  // namespace atwood::dynamics
