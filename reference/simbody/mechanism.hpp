// Joints and ropes of a scene in Simbody's terms. Conventions of Simbody 3.7:
//   - a placing joint is a mobilizer between a frame in the parent and a frame in the child; Pin and Cylinder turn
//     about its z, Slider moves along its x, Universal turns about x and then the new y. Their q are the scene's
//     coordinates;
//   - a ball has a quaternion, the scene's; its u are the relative angular velocity in the parent's frame, where the
//     scene's are in the child's axes;
//   - a closing joint is one or two constraints that are not redundant: ball Ball, fixed Weld, hinge Ball and
//     PointOnLine, slider ConstantOrientation and PointOnLine, cylindrical two PointOnLine, universal Ball and
//     ConstantAngle. A rope
//     between two points is a Rod;
//   - integrators project onto the constraints where constraint_tolerance asks for it;
//   - springs and dampers are Simbody's, motors a Force::Custom: both at every rate call;
//   - reactions come from Simbody's accelerations and constraint forces by Newton's and Euler's equations of each
//     subtree.
#pragma once

#include <Simbody.h>

#include <string>
#include <vector>

#include "protocol/sample.hpp"
#include "rivals/joints.hpp"
#include "scene/scene.hpp"

namespace atwood::simbody {

using Mobilized = std::vector<SimTK::MobilizedBody>;  // by body; fixed bodies are the ground

// Why Simbody cannot represent the scene's joints and ropes; empty when it can.
std::string refused_mechanism(const Scene& scene);

SimTK::MobilizedBody add_placed_body(const Scene& scene, int joint, const SimTK::Body& body,
                                     SimTK::MobilizedBody parent);

// The constraints that close a joint, and the rod of a rope.
struct Closings {
  std::vector<std::vector<SimTK::Constraint>> of_joint;
  std::vector<SimTK::Constraint::Rod> of_rope;
};
Closings add_closings(const Scene& scene, Mobilized& bodies);
void add_springs(const Scene& scene, SimTK::GeneralForceSubsystem& forces, Mobilized& bodies);

void set_joint(const Joint& joint, const SimTK::MobilizedBody& child, SimTK::State& state);
rivals::JointState joint_of(const Joint& joint, const SimTK::MobilizedBody& child, const SimTK::State& state);

// `state` realized to accelerations; wrenches: of the scene's forces, one per body or empty.
std::vector<rivals::Reaction> reactions_of(const Scene& scene, const Mobilized& bodies, const Closings& closings,
                                           const std::vector<rivals::Motion>& motions,
                                           const std::vector<rivals::Wrench>& wrenches, const SimTK::State& state);
std::vector<RopeSample> ropes_of(const Closings& closings, const SimTK::State& state);

}  // namespace atwood::simbody
